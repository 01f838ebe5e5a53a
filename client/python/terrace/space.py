# SPDX-License-Identifier: BSD-3-Clause
"""What takes up space beside the regions of a map: the leaves of the daemon's octree."""
import math
import struct

import numpy as np

_DEPTH = 16  # of an octree of OctoMap
_LEAST_ROUGHNESS_M, _MOST_ROUGHNESS_M, _ROUGHNESS_SIGMAS = 0.03, 0.15, 3.0


class OccupiedSpace:
    """The occupied leaves in a box, without those that a region of the map passes through:

        requests = terrace.Requests(bus)
        tree = requests.octree((-2, -2, -2), (2, 2, 2))
        space = terrace.OccupiedSpace(tree, query)
        query.capsule_clearance(a, b, radius_m, space=space)

    Where there is no leaf, the octree says nothing: it keeps what there is, not what there is not. Raises ValueError for an
    octree_v1_t that cannot be read, or of another map than the query's.
    """

    def __init__(self, message, query):
        self.box_min, self.box_max = np.array(message.box_min), np.array(message.box_max)
        if not np.all(self.box_min <= self.box_max) or message.encoding != message.OCTOMAP_OT:
            raise ValueError("octree: says no box, or is no .ot")
        if message.map_id != query.terrain.map_id:
            raise ValueError("octree: is of another map")
        low, high = read_ot(bytes(message.data))
        kept = [i for i in range(len(low)) if not _on_a_region(0.5 * (low[i] + high[i]), 0.5 * (high[i] - low[i])[0], query)]
        self.low, self.high = low[kept], high[kept]  #: (n, 3) lowest and highest corners of the leaves [m], world

    def nearest_to(self, a, b):
        """How near the segment from a to b comes to the nearest leaf: distance (negative: through it, and out of it by a move
        so far) and the unit way from it; (inf, zeros) where there is none."""
        if len(self.low) == 0:
            return math.inf, np.zeros(3)
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        points = a + _nearest_parameters(a, b - a, self.low, self.high)[:, None] * (b - a)
        away = points - np.clip(points, self.low, self.high)
        distances = np.linalg.norm(away, axis=1)
        for i in np.flatnonzero(distances == 0.0):
            distances[i], away[i] = _way_out(a, b, self.low[i], self.high[i])
        nearest = int(np.argmin(distances))
        return float(distances[nearest]), away[nearest] / np.linalg.norm(away[nearest])

    def has_been_asked(self, a, b, radius_m):
        """Whether the whole capsule lies in the box that the octree was asked about."""
        return bool(np.all(np.minimum(a, b) - radius_m >= self.box_min) and np.all(np.maximum(a, b) + radius_m <= self.box_max))


def read_ot(data):
    """Lowest and highest corners [m] of the leaves of an OctoMap file (`.ot` of an OcTree) that are more likely occupied than
    free: two (n, 3) arrays. Raises ValueError where the bytes are no such file."""
    mark = data.find(b"\ndata\n", 0, 1024)
    if not data.startswith(b"# Octomap OcTree file") or mark < 0:
        raise ValueError("octree: is no file of OctoMap's .ot")
    header = dict(line.split(" ", 1) for line in data[:mark].decode(errors="replace").splitlines() if " " in line)
    try:
        leaf_m, num_nodes = float(header["res"]), int(header["size"])
    except (KeyError, ValueError):
        raise ValueError("octree: has no size of a leaf, or no number of nodes") from None
    if header.get("id") != "OcTree" or not 0.0 < leaf_m < math.inf:
        raise ValueError("octree: is of another kind, or has no size of a leaf")
    at, corners, edges = mark + len(b"\ndata\n"), [], []
    waiting = [((-(1 << _DEPTH - 1),) * 3, 1 << _DEPTH)] if num_nodes > 0 else []
    while waiting:
        (x, y, z), edge = waiting.pop()
        if at + 5 > len(data):
            raise ValueError("octree: ends in the middle of a node")
        log_odds, children = struct.unpack_from("<fB", data, at)
        at += 5
        if children and edge == 1:
            raise ValueError("octree: is deeper than an octree of OctoMap")
        if not children and log_odds > 0.0:
            corners.append((x, y, z))
            edges.append(edge)
        half = edge // 2
        waiting += [((x + half * (c & 1), y + half * (c >> 1 & 1), z + half * (c >> 2)), half)
                    for c in range(7, -1, -1) if children >> c & 1]
    if at != len(data):
        raise ValueError("octree: goes on behind its last node")
    low = leaf_m * np.array(corners, dtype=float).reshape(-1, 3)
    return low, low + leaf_m * np.array(edges, dtype=float)[:, None]


def _on_a_region(point, distance_m, query):
    for region_id in query.regions_near(point, distance_m + _MOST_ROUGHNESS_M):
        region, shape = query.terrain.regions[region_id], query._shapes[region_id]
        near = distance_m + min(max(_ROUGHNESS_SIGMAS * region.rms_m, _LEAST_ROUGHNESS_M), _MOST_ROUGHNESS_M)
        off = shape.normal @ (point - shape.origin)
        if region.source == "predicted" or abs(off) > near:
            continue
        below = point - off * shape.normal
        if shape.contains_point(below) or shape.edge_distances(below[None]).min() <= near:
            return True
    return False


def _nearest_parameters(a, along, low, high):
    """Where a + t * along, t in [0, 1], is nearest to each box. The slope of the squared distance grows with t, on a straight
    line between the planes of the box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.concatenate([(low - a) / along, (high - a) / along], axis=1)
    crossings = np.clip(np.nan_to_num(crossings, nan=0.0), 0.0, 1.0)
    t = np.sort(np.concatenate([np.zeros((len(low), 1)), crossings, np.ones((len(low), 1))], axis=1), axis=1)
    points = a + t[..., None] * along
    slopes = (points - np.clip(points, low[:, None], high[:, None])) @ along
    after = np.where((slopes >= 0.0).any(axis=1), np.argmax(slopes >= 0.0, axis=1), t.shape[1] - 1)
    before = np.maximum(after - 1, 0)
    rows = np.arange(len(low))
    s0, s1, t0, t1 = slopes[rows, before], slopes[rows, after], t[rows, before], t[rows, after]
    crosses = (s0 < 0.0) & (s1 >= 0.0)
    return np.where(crosses, t0 + (t1 - t0) * s0 / np.where(crosses, s0 - s1, 1.0), t1)


def _way_out(a, b, low, high):
    """The least move along an axis that takes the whole segment out of the box: minus its length, and the way."""
    moves = np.concatenate([high - np.minimum(a, b), np.maximum(a, b) - low])
    k = int(np.argmin(moves))
    return -moves[k], np.eye(3)[k % 3] * (1.0 if k < 3 else -1.0)
