# SPDX-License-Identifier: BSD-3-Clause
"""What a planner in Python needs of Terrace: the labelled terrain map of a legged robot, and answers from it.

    bus = terrace.Bus()                        # LCM over UDP, without the module `lcm`
    terrain = terrace.TerrainClient(bus)       # keeps the map in step with the daemon
    bus.handle(timeout_s=1.0)                  # receives; terrain.map is the newest state, or None
    query = terrace.TerrainQuery(terrain.map)  # needs numpy
    query.support_at(1.0, 0.2)                 # ground: point, normal, sigma, nearest edge, label, age; or None
    query.nearest_foothold((1.0, 0.2, 0.0), reach_xy_m=0.2, dz_m=0.2)

Without a daemon: `terrace.load_result(folder)` reads the map that `terraced replay` left, `terrace.load_terrace(file)` one that
was saved, `terrace.read_log(path)` an LCM log. `terrace.Requests(bus)` asks for octree, disparity and heights. Every message type is a class of this package (`terrace.pose_v1_t`, ...) with `encode()` and `decode(bytes)`, made by
lcm-gen. All lengths are metres, angles radians, times seconds unless a name says otherwise; the frame is `world` (z up).
"""
from ._messages import *  # noqa: F401,F403
from .bus import Bus
from .client import TerrainClient
from .follower import TerrainFollower
from .log import LogEvent, read_log
from .requests import RequestRefused, Requests
from .result import load_result
from .terrace_file import load_terrace
from .terrain import Edge, Region, Staircase, Terrain


def __getattr__(name):
    """The queries, which need numpy, are loaded when they are first used."""
    if name in ("TerrainQuery", "FootSpec", "Support", "Foothold", "HeightGrid", "Clearance"):
        from . import query
        return getattr(query, name)
    if name == "OccupiedSpace":
        from . import space
        return space.OccupiedSpace
    raise AttributeError(f"module 'terrace' has no attribute '{name}'")
