// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "terrace/client/terrain_client.h"

int main() {
  lcm::LCM lcm("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  terrace::TerrainClient terrain(&lcm);
  while (lcm.handle() == 0) {
    const terrace::TerrainMapPtr map = terrain.map();  // in step with the daemon, whatever was lost
    if (!map) continue;                                // nothing has arrived yet
    double walkable_m2 = 0.0;
    for (const auto& region : map->regions) {
      if (region->label == terrace::TerrainLabel::kWalkway) walkable_m2 += region->area_m2;
    }
    std::printf("%zu regions, %.1f m2 to walk on\n", map->regions.size(), walkable_m2);
    for (const terrace::Staircase& stairs : map->staircases) {
      const double distance_m = (stairs.base_world() - map->T_world_left.translation()).norm();
      std::printf("  %d steps of %.2f m, %.1f m away\n", stairs.num_risers, stairs.riser_m, distance_m);
    }
  }
}
