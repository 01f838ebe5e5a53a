#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints where the left front foot may stand, as soon as the map is there. An argument: a result instead of a daemon."""
import sys

import terrace

if len(sys.argv) > 1:
    terrain = terrace.load_result(sys.argv[1])
else:
    client = terrace.TerrainClient(terrace.Bus())
    terrain = client.wait(timeout_s=60.0)
if terrain is None:
    sys.exit("nothing was heard: is terraced running, or `terrace serve RESULT`?")
print(f"{len(terrain.regions)} regions, {len(terrain.staircases)} staircases")
query = terrace.TerrainQuery(terrain)
for region in terrain.labelled("walkway", "stair_tread"):
    foothold = query.nearest_foothold(region.origin, reach_xy_m=0.3, dz_m=0.1)
    if foothold is not None:
        print("foothold on", foothold.support.label, foothold.support.point.round(3), foothold.support.edge.kind)
        break
