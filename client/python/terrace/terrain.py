# SPDX-License-Identifier: BSD-3-Clause
"""The map as Python sees it. Nothing in it changes once it is there: the next state is another Terrain, which shares the
regions that have not changed."""
import dataclasses
import math
from typing import Dict, List, Optional, Tuple

Vector = Tuple[float, float, float]

#: Names of the labels by their number in region_v1_t.
LABELS = ("unknown", "walkway", "ramp", "stair_tread", "stair_riser", "wall", "obstacle", "level")
#: What feet may stand on.
WALKABLE = frozenset(("walkway", "ramp", "stair_tread"))
#: Names of the kinds of edges by their number in region_v1_t.
EDGE_KINDS = ("limit", "drop", "rise", "joins")
#: How a region is known, by its number in region_v1_t.
SOURCES = ("seen", "predicted", "feet")


@dataclasses.dataclass(frozen=True)
class Edge:
    """What lies beyond one edge of a region."""
    kind: str  #: "limit" (of view), "drop", "rise" or "joins"
    step_m: Optional[float] = None  #: height of what lies beyond, negative: lower; None: not known
    sigma_m: Optional[float] = None  #: of step_m


@dataclasses.dataclass(frozen=True)
class Region:
    """One planar piece of terrain."""
    id: int
    revision: int
    label: str  #: one of LABELS
    confidence: float  #: of the label, 0..1
    normal: Vector  #: unit, world, to the side that was seen
    origin: Vector  #: a point of the plane near its middle [m], world
    rings: Tuple[Tuple[Vector, ...], ...]  #: outline counter-clockwise seen from the normal, then holes [m], world
    edges: Tuple[Edge, ...]  #: one for each vertex, ring after ring: the edge that starts there
    area_m2: float
    rms_m: float = 0.0  #: of what was seen, about the plane
    source: str = "seen"  #: one of SOURCES
    plane_cov: Optional[Tuple[Vector, Vector, Vector]] = None  #: tilts [rad] and offset [m] about origin; None: not known
    axes: Optional[Tuple[Vector, Vector]] = None  #: x and y of the plane frame that plane_cov is in
    why: str = ""  #: what keeps the region undecided
    first_seen_ns: int = 0
    last_seen_ns: int = 0
    staircase_id: Optional[int] = None
    step_index: Optional[int] = None  #: riser 1 is the lowest, tread 1 lies above riser 1


@dataclasses.dataclass(frozen=True)
class Staircase:
    """A flight of steps."""
    id: int
    num_risers: int
    num_treads: int
    riser_m: float
    tread_m: float
    width_m: float
    base: Vector  #: middle of the foot edge [m], world
    direction_up: Vector  #: unit, level
    confidence: float
    turn_per_step_rad: float = 0.0  #: 0: straight; positive turns left going up


@dataclasses.dataclass(frozen=True)
class Terrain:
    """One state of the map."""
    t_capture_ns: int  #: newest image included
    map_id: int
    seq: int
    regions: Dict[int, Region]  #: by id
    staircases: Dict[int, Staircase]  #: by id
    gravity: Vector = (0.0, 0.0, -1.0)  #: unit, world, down
    sensor_pos: Vector = (0.0, 0.0, 0.0)  #: left camera [m], world

    def age_s(self, region: Region) -> float:
        """How long before the map's newest image the region was seen last."""
        return 1e-9 * (self.t_capture_ns - region.last_seen_ns)

    def labelled(self, *labels: str) -> List[Region]:
        """The regions with one of the labels, by ascending id."""
        return [region for _, region in sorted(self.regions.items()) if region.label in labels]


def axes_of(normal: Vector) -> Tuple[Vector, Vector]:
    """Two axes in a plane with x cross y = normal; those that plane covariances are written in."""
    seed = (0.0, 1.0, 0.0) if abs(normal[0]) >= 0.8 else (1.0, 0.0, 0.0)
    along = sum(n * s for n, s in zip(normal, seed))
    x = [s - n * along for n, s in zip(normal, seed)]
    length = math.sqrt(sum(v * v for v in x))
    x = tuple(v / length for v in x)
    n = normal
    return x, (n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0])
