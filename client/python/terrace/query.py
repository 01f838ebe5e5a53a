# SPDX-License-Identifier: BSD-3-Clause
"""Questions to one map, with numpy: the ground, footholds, grids of heights. The C++ class of the same name answers the same.

Written in Python on numpy rather than bound to the C++ library, so that the package needs no compiler and runs wherever
Python does; one question takes tenths of a millisecond instead of microseconds.
"""
import dataclasses
import math
from typing import FrozenSet, Optional

import numpy as np

from .terrain import LABELS, WALKABLE, Edge

_CARRIES = 0.5  # what faces up less is no ground: cos 60 deg
_STEP_M = 0.002  # between the places that are tried along the border of where a foot fits


@dataclasses.dataclass(frozen=True)
class Support:
    """One point of the ground and what is known about it."""
    point: np.ndarray  #: (3,) m, world
    normal: np.ndarray  #: (3,) unit, world
    sigma_height_m: float  #: of the height along z; NaN: not known
    edge_distance_m: float  #: to the region's nearest edge, along its plane
    edge: Edge  #: that edge
    label: str
    confidence: float  #: of the label
    age_s: float  #: of the region's newest sight, at the map's newest image
    source: str  #: "seen", "predicted" or "feet"
    region_id: int


@dataclasses.dataclass(frozen=True)
class FootSpec:
    """What a foot needs of the ground that it is set on."""
    radius_m: float = 0.03  #: of the sole; all of it stands on one region
    clear_drop_m: float = 0.02  #: from the sole to an edge over a drop
    clear_rise_m: float = 0.01  #: from the sole to an edge below an upright face
    max_slope_rad: float = math.radians(30.0)  #: between the region's normal and up, by the map's gravity
    min_confidence: float = 0.5
    max_age_s: float = math.inf
    allow_predicted: bool = False  #: also on what was inferred and never seen
    labels: FrozenSet[str] = WALKABLE


@dataclasses.dataclass(frozen=True)
class Foothold:
    """Where a foot may be set."""
    support: Support
    distance_m: float  #: from the nominal point


@dataclasses.dataclass(frozen=True)
class Clearance:
    """How far a capsule is from all that is known."""
    distance_m: float  #: from its surface to the nearest face or leaf; negative: to be moved by so much; inf: there is none
    gradient: np.ndarray  #: (3,) unit, world: the way in which a move takes it away from that; zero: there is none
    region_id: int  #: of the nearest face; 0: a leaf is nearer, or there is none
    occupancy: str  #: "free" (only where the octree was asked, over seen ground), "occupied" or "unknown"


@dataclasses.dataclass(frozen=True)
class HeightGrid:
    """Heights of the highest ground; all arrays are (num_x, num_y), cell (i, j) about first_xy + cell_m * (i, j)."""
    first_xy: tuple
    cell_m: float
    height_m: np.ndarray  #: NaN: nothing is known
    sigma_m: np.ndarray
    age_s: np.ndarray
    region_id: np.ndarray  #: 0: nothing is known


class _Shape:
    """One revision of a region: its vertices and edges as arrays."""

    def __init__(self, region):
        self.normal = np.array(region.normal)
        self.origin = np.array(region.origin)
        self.axes = np.array(region.axes)
        self.start = np.concatenate([np.array(ring) for ring in region.rings])
        self.end = np.concatenate([np.roll(np.array(ring), -1, axis=0) for ring in region.rings])
        self.low, self.high = self.start.min(axis=0), self.start.max(axis=0)
        self.kinds = np.array([edge.kind for edge in region.edges])
        self.carries = self.normal[2] > _CARRIES

    def height_at(self, xy):
        """Heights of the plane over (..., 2) points."""
        return self.origin[2] - (np.asarray(xy) - self.origin[:2]) @ self.normal[:2] / self.normal[2]

    def contains(self, xy):
        """Whether (n, 2) points of the plan lie inside: by the number of edges towards +x."""
        x, y = xy[:, :1], xy[:, 1:]
        ax, ay, bx, by = self.start[:, 0], self.start[:, 1], self.end[:, 0], self.end[:, 1]
        crosses = (ay > y) != (by > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = ax + (y - ay) / (by - ay) * (bx - ax)
        return np.count_nonzero(crosses & (x < at), axis=1) % 2 == 1

    def contains_point(self, point):
        """Whether the point of the plane below a point lies inside, upright faces too."""
        start, end, p = ((np.atleast_2d(q) - self.origin) @ self.axes.T for q in (self.start, self.end, point))
        (x, y), ax, ay, bx, by = p[0], start[:, 0], start[:, 1], end[:, 0], end[:, 1]
        k = np.flatnonzero((ay > y) != (by > y))
        return np.count_nonzero(x < ax[k] + (y - ay[k]) / (by[k] - ay[k]) * (bx[k] - ax[k])) % 2 == 1

    def inside_columns(self, xs, ys):
        """The same for all points (x, y) of a grid with ascending ys: (len(xs), len(ys))."""
        ax, ay, bx, by = self.start[:, 0], self.start[:, 1], self.end[:, 0], self.end[:, 1]
        inside = np.zeros((len(xs), len(ys)), dtype=bool)
        for i, x in enumerate(xs):
            k = np.flatnonzero((ax > x) != (bx > x))
            at = np.sort(ay[k] + (x - ax[k]) / (bx[k] - ax[k]) * (by[k] - ay[k]))
            inside[i] = np.searchsorted(at, ys) % 2 == 1
        return inside

    def edge_distances(self, points):
        """Distances of (n, 3) points to all m edges: (n, m)."""
        along = self.end - self.start
        length2 = np.maximum(np.einsum("mk,mk->m", along, along), 1e-18)
        offset = points[:, None, :] - self.start
        t = np.clip(np.einsum("nmk,mk->nm", offset, along) / length2, 0.0, 1.0)
        return np.linalg.norm(offset - t[..., None] * along, axis=2)


class TerrainQuery:
    """Answers questions to one Terrain. It never changes; for the next map make another one `from` it:

        query = TerrainQuery(map)
        query = TerrainQuery(next_map, before=query)  # takes over the regions that have not changed

    What is not found is not known: no ground is invented between regions.
    """

    def __init__(self, terrain, before: Optional["TerrainQuery"] = None):
        #: The map that is asked.
        self.terrain = terrain
        self._shapes = {}
        old = before if before is not None and before.terrain.map_id == terrain.map_id else None
        for region_id, region in sorted(terrain.regions.items()):
            known = old is not None and region_id in old.terrain.regions \
                and old.terrain.regions[region_id].revision == region.revision
            self._shapes[region_id] = old._shapes[region_id] if known else _Shape(region)
        self._ids = np.array(list(self._shapes), dtype=np.int64)
        self._low = np.array([s.low for s in self._shapes.values()]).reshape(-1, 3)
        self._high = np.array([s.high for s in self._shapes.values()]).reshape(-1, 3)

    def supports_at(self, x, y):
        """The ground of all storeys at (x, y), whatever its label: a list of Support, the highest first."""
        xy = np.array([x, y], dtype=float)
        found = []
        for region_id in self._ids[np.all((self._low[:, :2] <= xy) & (xy <= self._high[:, :2]), axis=1)]:
            shape = self._shapes[region_id]
            if shape.carries and shape.contains(xy[None])[0]:
                found.append(self._support(int(region_id), np.append(xy, shape.height_at(xy))))
        return sorted(found, key=lambda support: (-support.point[2], support.region_id))

    def support_at(self, x, y, z_min=-math.inf, z_max=math.inf, labels=WALKABLE):
        """The highest ground at (x, y) with a height in [z_min, z_max] and one of the labels: a Support, or None."""
        for support in self.supports_at(x, y):
            if z_min <= support.point[2] <= z_max and support.label in labels:
                return support
        return None

    def nearest_foothold(self, nominal, reach_xy_m, dz_m, foot=FootSpec()):
        """The place for a foot that is nearest to the point `nominal` (x, y, z), within reach_xy_m of it in the plan and
        dz_m in height: a Foothold, or None. The sole keeps clear of all edges by what `foot` says; places are tried
        every 2 mm, so that a nearer one may be missed by so much."""
        nominal = np.asarray(nominal, dtype=float)
        reach = np.array([reach_xy_m, reach_xy_m, dz_m])
        best, best_distance = None, math.inf
        to_box = np.linalg.norm(np.maximum(0.0, np.maximum(self._low - nominal, nominal - self._high)), axis=1)
        in_reach = np.all((self._low <= nominal + reach) & (nominal - reach <= self._high), axis=1)
        for k in np.argsort(to_box, kind="stable"):
            region_id = int(self._ids[k])
            if to_box[k] >= best_distance or not in_reach[k] or not self._fits(region_id, foot):
                continue
            furthest = min(math.hypot(reach_xy_m, dz_m), best_distance)
            for point in self._places(self._shapes[region_id], nominal, reach_xy_m, dz_m, foot, furthest):
                distance = float(np.linalg.norm(point - nominal))
                if distance < best_distance:
                    best, best_distance = (region_id, point), distance
        return None if best is None else Foothold(self._support(*best), best_distance)

    def heights(self, first_xy, cell_m=0.015, num_x=100, num_y=100, z_min=-math.inf, z_max=math.inf, labels=None):
        """The highest ground in every cell of a grid along the world's axes: a HeightGrid. labels None: all."""
        xs, ys = first_xy[0] + cell_m * np.arange(num_x), first_xy[1] + cell_m * np.arange(num_y)
        grid = HeightGrid(tuple(first_xy), cell_m, *(np.full((num_x, num_y), np.nan) for _ in range(3)),
                          np.zeros((num_x, num_y), dtype=np.int64))
        for region_id, shape in self._shapes.items():
            region = self.terrain.regions[region_id]
            i = np.flatnonzero((shape.low[0] <= xs) & (xs <= shape.high[0]))
            j = np.flatnonzero((shape.low[1] <= ys) & (ys <= shape.high[1]))
            if not shape.carries or (labels is not None and region.label not in labels) or not i.size or not j.size:
                continue
            inside = np.zeros((num_x, num_y), dtype=bool)
            inside[np.ix_(i, j)] = shape.inside_columns(xs[i], ys[j])
            cells = np.argwhere(inside)
            xyz = np.stack([xs[cells[:, 0]], ys[cells[:, 1]], np.zeros(len(cells))], axis=1)
            xyz[:, 2] = shape.height_at(xyz[:, :2])
            held = grid.height_m[cells[:, 0], cells[:, 1]]
            higher = (np.isnan(held) | (held < xyz[:, 2])) & (z_min <= xyz[:, 2]) & (xyz[:, 2] <= z_max)
            at, xyz = tuple(cells[higher].T), xyz[higher]
            grid.height_m[at] = xyz[:, 2]
            grid.sigma_m[at] = self._sigma(region, shape, xyz)
            grid.age_s[at] = self.terrain.age_s(region)
            grid.region_id[at] = region_id
        return grid

    def regions_near(self, point, distance_m):
        """Ids of the regions whose boxes come within the distance of a point, ascending."""
        to_box = np.maximum(0.0, np.maximum(self._low - point, point - self._high))
        return [int(i) for i in self._ids[np.linalg.norm(to_box, axis=1) <= distance_m]]

    def capsule_clearance(self, a, b, radius_m, labels=None, space=None):
        """How far all points within radius_m of the segment from a to b (a leg, a body) are from the faces of regions with
        one of the labels (None: all), and from what else takes up space: a Clearance. `space` is the OccupiedSpace around
        there; None: nobody has asked the octree, and nothing is called free."""
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        best = (math.inf, np.zeros(3), 0, False)
        low, high = np.minimum(a, b), np.maximum(a, b)
        to_box = np.linalg.norm(np.maximum(0.0, np.maximum(self._low - high, low - self._high)), axis=1)
        for k in np.argsort(to_box, kind="stable"):
            if to_box[k] > max(best[0], 0.0):
                break
            region_id = int(self._ids[k])
            if labels is not None and self.terrain.regions[region_id].label not in labels:
                continue
            axis_m, away, from_behind = _approach(self._shapes[region_id], a, b)
            if axis_m < best[0]:
                best = (axis_m, away, region_id, from_behind)
        from_behind = best[3]
        if space is not None:
            leaf_m, away = space.nearest_to(a, b)
            best = (leaf_m, away, 0) if leaf_m < best[0] else best
        distance = best[0] - radius_m
        occupancy = "occupied" if distance <= 0.0 else "unknown"
        if distance > 0.0 and space is not None and space.has_been_asked(a, b, radius_m) and not from_behind \
                and self._over_seen_ground(a, b):
            occupancy = "free"
        return Clearance(distance, best[1], best[2], occupancy)

    def _over_seen_ground(self, a, b):
        steps = math.ceil(float(np.hypot(*(b - a)[:2])) / 0.05)
        for i in range(steps + 1):
            p = a + (b - a) * (i / steps if steps else 0.0)
            below = self.support_at(p[0], p[1], z_max=p[2] if steps else min(a[2], b[2]), labels=LABELS)
            if below is None or below.source == "predicted":
                return False
        return True

    @staticmethod
    def _sigma(region, shape, points):
        """Standard deviations of the plane's height at (n, 3) points of it."""
        if region.plane_cov is None:
            return np.full(len(points), np.nan)
        u, v = (points - shape.origin) @ shape.axes.T[:, 0], (points - shape.origin) @ shape.axes.T[:, 1]
        lift = np.stack([v, -u, np.ones_like(u)], axis=1)  # a tilt about x lifts what lies at +y
        variance = np.einsum("ni,ij,nj->n", lift, np.array(region.plane_cov), lift)
        return np.sqrt(np.maximum(variance, 0.0)) / abs(shape.normal[2])

    def _support(self, region_id, point):
        region, shape = self.terrain.regions[region_id], self._shapes[region_id]
        distances = shape.edge_distances(point[None])[0]
        nearest = int(np.argmin(distances))
        return Support(point, shape.normal, float(self._sigma(region, shape, point[None])[0]), float(distances[nearest]),
                       region.edges[nearest], region.label, region.confidence, self.terrain.age_s(region), region.source,
                       region_id)

    def _fits(self, region_id, foot):
        region, shape = self.terrain.regions[region_id], self._shapes[region_id]
        up = -np.array(self.terrain.gravity)
        return shape.carries and region.label in foot.labels and region.confidence >= foot.min_confidence \
            and (foot.allow_predicted or region.source != "predicted") and self.terrain.age_s(region) <= foot.max_age_s \
            and shape.normal @ up >= math.cos(foot.max_slope_rad)

    @staticmethod
    def _places(shape, nominal, reach_xy_m, dz_m, foot, furthest):
        """The point of the region where the foot fits that is nearest to `nominal`, within 2 mm; none further than
        `furthest` from the point below it."""
        margins = foot.radius_m + np.where(shape.kinds == "drop", foot.clear_drop_m, 0.0) \
            + np.where(shape.kinds == "rise", foot.clear_rise_m, 0.0) + 1e-9
        below = nominal - shape.normal * (shape.normal @ (nominal - shape.origin))
        distances = shape.edge_distances(below[None])[0]
        radius = 0.0
        while True:
            # Where the nearest point is not the one below, it lies at its margin from some edge.
            points = np.concatenate([below[None]] + [
                _at_margin(shape, k, margins[k]) for k in np.flatnonzero(distances <= radius + margins)])
            away = points - nominal
            points = points[(np.linalg.norm(points - below, axis=1) <= radius)
                            & (np.hypot(away[:, 0], away[:, 1]) <= reach_xy_m) & (np.abs(away[:, 2]) <= dz_m)]
            points = points[np.argsort(np.linalg.norm(points - nominal, axis=1), kind="stable")]
            for few in np.array_split(points, len(points) // 64 + 1):  # the first that fits is the nearest
                fits = shape.contains(few[:, :2]) & np.all(shape.edge_distances(few) >= margins - 2e-9, axis=1)
                if fits.any():
                    return [few[np.argmax(fits)]]
            if radius >= furthest:
                return []
            radius = min(furthest, max(0.03, 2.0 * radius))


def _approach(shape, a, b):
    """How near the segment a-b comes to a face: distance (negative: through it by so much), the unit way from it, and whether
    it lies behind the side that was seen."""
    over_a, over_b = shape.normal @ (a - shape.origin), shape.normal @ (b - shape.origin)
    if over_a * over_b < 0.0 and shape.contains_point(a + over_a / (over_a - over_b) * (b - a)):
        up, down = -min(over_a, over_b), max(over_a, over_b)
        return (-up, shape.normal, False) if up <= down else (-down, -shape.normal, False)
    best, away, beside = math.inf, np.zeros(3), False
    for point, over in ((a, over_a), (b, over_b)):
        if abs(over) < best and shape.contains_point(point):
            best, away = abs(over), over * shape.normal
    between = _between_segments(a, b, shape.start, shape.end)
    distances = np.linalg.norm(between, axis=1)
    nearest = int(np.argmin(distances))
    if distances[nearest] < best:
        best, away, beside = float(distances[nearest]), between[nearest], True
    length = np.linalg.norm(away)
    return best, away / length if length > 0.0 else shape.normal, not beside and away @ shape.normal < 0.0


def _between_segments(a, b, c, d):
    """From the nearest point of each segment c-d to that of a-b: (m, 3). C. Ericson, "Real-Time Collision Detection", 2005,
    section 5.1.9."""
    u, v, r = b - a, d - c, a - c
    uu, vv = u @ u, np.maximum(np.einsum("mk,mk->m", v, v), 1e-18)
    ur, vr, uv = r @ u, np.einsum("mk,mk->m", v, r), v @ u
    denominator = uu * vv - uv * uv
    apart = denominator > 1e-18
    s = np.where(apart, np.clip((uv * vr - ur * vv) / np.where(apart, denominator, 1.0), 0.0, 1.0), 0.0)
    t = np.clip((uv * s + vr) / vv, 0.0, 1.0)
    if uu > 1e-18:
        s = np.clip((uv * t - ur) / uu, 0.0, 1.0)
    return r + s[:, None] * u - t[:, None] * v


def _at_margin(shape, k, margin):
    """Points every 2 mm at `margin` from edge k, on the inner side, and around the vertex that it starts at."""
    start, end = shape.start[k], shape.end[k]
    inward = np.cross(shape.normal, end - start)
    inward /= max(np.linalg.norm(inward), 1e-12)
    t = np.linspace(0.0, 1.0, max(2, math.ceil(np.linalg.norm(end - start) / _STEP_M)))[:, None]
    turns = np.linspace(0.0, 2.0 * math.pi, math.ceil(2.0 * math.pi * margin / _STEP_M) + 1)[:, None]
    around = start + margin * (np.cos(turns) * shape.axes[0] + np.sin(turns) * shape.axes[1])
    return np.concatenate([start + t * (end - start) + margin * inward, around])
