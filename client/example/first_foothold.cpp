// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "terrace/client/terrain_client.h"
#include "terrace/client/terrain_query.h"

int main() {
  lcm::LCM lcm("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  terrace::TerrainClient client(&lcm);
  while (!client.in_step()) lcm.handleTimeout(50);
  const terrace::TerrainQuery query(client.map());
  for (const auto& region : client.map()->regions) {
    if (!terrace::kWalkableLabels.Has(region->label)) continue;
    const auto foothold = query.NearestFoothold(region->centroid_world, 0.3, 0.1);
    if (!foothold) continue;
    const Eigen::Vector3d& p = foothold->support.point_world;
    std::printf("a foot may stand on a %s at %.3f %.3f %.3f\n", terrace::Name(region->label), p.x(), p.y(),
                p.z());
    return 0;
  }
  std::printf("no foothold in %zu regions\n", client.map()->regions.size());
  return 1;
}
