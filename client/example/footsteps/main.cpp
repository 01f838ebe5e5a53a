// SPDX-License-Identifier: BSD-3-Clause
// Plans footsteps over the daemon's map to a place, publishes the plan on TERRACE_FOOTSTEPS and leaves it in
// files: terrace_footsteps X Y [PLAN.svg] [PLAN.footsteps], a picture and the message's bytes. The walker
// starts where the map is seen from, or at the first ground before it.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "client/example/footsteps/footstep_search.h"
#include "client/example/footsteps/plan_message.h"
#include "client/example/footsteps/plan_picture.h"
#include "terrace/client/terrain_client.h"
#include "terrace/client/terrain_query.h"

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The ground under the camera, or before it within a metre; none: not known.
std::optional<terrace::PlanEnd> StartOf(const terrace::TerrainQuery& query) {
  const Eigen::Isometry3d& T_world_left = query.map().T_world_left;
  const Eigen::Vector3d ahead = T_world_left.linear().col(2);
  const double heading_rad = std::atan2(ahead.y(), ahead.x());
  for (double along_m = 0.0; along_m < 1.0; along_m += 0.05) {
    const Eigen::Vector2d xy = T_world_left.translation().head<2>() +
                               along_m * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
    const auto ground = query.SupportAt(xy, -kInfinity, T_world_left.translation().z());
    if (ground) return terrace::PlanEnd{ground->point_world, heading_rad};
  }
  return std::nullopt;
}

terrace::TerrainMapPtr WaitForMap(lcm::LCM* lcm, double patience_s) {
  if (!lcm->good()) return nullptr;
  terrace::TerrainClient client(lcm);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  while (!client.in_step() && std::chrono::steady_clock::now() < end) lcm->handleTimeout(50);
  return client.in_step() ? client.map() : nullptr;
}

/// A picture, or the message's bytes, by how the name ends.
void Write(const std::string& path, const terrace::TerrainMap& map,
           const std::vector<terrace::Footstep>& steps, const terrace::footstep_plan_v1_t& plan) {
  std::ofstream file(path, std::ios::binary);
  if (path.ends_with(".footsteps")) {
    std::vector<char> bytes(static_cast<std::size_t>(plan.getEncodedSize()));
    plan.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  } else {
    file << terrace::PlanPicture(map, steps, plan.foot_radius);
  }
  file.close();
  if (!file) std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s X Y [PLAN.svg] [PLAN.footsteps]\n", argv[0]);
    return 2;
  }
  lcm::LCM lcm("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  const terrace::TerrainMapPtr map = WaitForMap(&lcm, 60.0);
  if (!map) {
    std::fprintf(stderr, "nothing was heard: is terraced running, or `terrace serve RESULT`?\n");
    return 1;
  }
  const terrace::TerrainQuery query(map);
  const auto start = StartOf(query);
  const auto goal = query.SupportAt({std::atof(argv[1]), std::atof(argv[2])}, -kInfinity, kInfinity);
  if (!start || !goal) {
    std::fprintf(stderr, "no ground is known %s\n", start ? "at the goal" : "under or before the camera");
    return 1;
  }
  const terrace::Walker walker;
  const auto steps = terrace::PlanFootsteps(query, walker, *start, {goal->point_world, 0.0});
  for (const terrace::Footstep& step : steps) {
    const Eigen::Vector3d& p = step.ground.point_world;
    std::printf("%-5s  %7.3f %7.3f %7.3f  %s, sigma %.1f mm\n", step.left ? "left" : "right", p.x(), p.y(),
                p.z(), terrace::Name(step.ground.label), 1e3 * step.ground.sigma_height_m);
  }
  const terrace::footstep_plan_v1_t plan = terrace::PlanMessage(*map, steps, walker.foot.radius_m);
  lcm.publish("TERRACE_FOOTSTEPS", &plan);
  for (int i = 3; i < argc; ++i) Write(argv[i], *map, steps, plan);
  if (steps.empty()) std::fprintf(stderr, "no way was found\n");
  return steps.empty() ? 1 : 0;
}
