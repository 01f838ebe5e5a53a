// SPDX-License-Identifier: BSD-3-Clause
// Plans footsteps on replayed maps of places whose truth is known, and judges every foothold by it: a foot is
// right when true walkable ground lies under its sole less 1 cm all around, within 1 cm of its height.
// Arguments: result and sequence in turn. The last line is one JSON object.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "bench/client/true_ground.h"
#include "client/example/footsteps/footstep_search.h"
#include "client/example/footsteps/plan_picture.h"
#include "client/terrain_query.h"
#include "datasets/ground_truth.h"
#include "results/replay_result.h"

namespace terrace {
namespace {

/// Ground of the map where the camera was, the first or the last one of the walk with room for two feet.
std::optional<PlanEnd> EndOf(const TerrainQuery& query, const Walker& walker,
                             const std::vector<ResultPose>& poses) {
  for (const ResultPose& pose : poses) {
    const Eigen::Vector3d ahead = pose.T_world_left.linear().col(2);
    const Eigen::Vector3d& eye = pose.T_world_left.translation();
    const auto ground = query.SupportAt(eye.head<2>(), eye.z() - 1.5, eye.z());
    if (!ground || ground->edge_distance_m < 0.5 * walker.stance_width_m + 0.1) continue;
    return PlanEnd{ground->point_world, std::atan2(ahead.y(), ahead.x())};
  }
  return std::nullopt;
}

struct PlanCounts {
  int num_places = 0;
  int num_reached = 0;
  int num_placements = 0;
  int num_right = 0;
};

void Judge(const std::filesystem::path& result_folder, const std::filesystem::path& sequence,
           PlanCounts* counts) {
  const ReplayResult result = ReadReplayResult(result_folder);
  const TrueTrajectory trajectory = LoadTrueTrajectory(sequence);
  auto map = std::make_shared<TerrainMap>(result.map);
  map->gravity = result.stats.gravity;
  const TerrainQuery query(map);
  const Eigen::Isometry3d T_map_truth =
      result.trajectory.front().T_world_left * trajectory.poses.front().T_world_frame.inverse();
  const TerrainQuery truth(TrueGround(LoadTrueScene(sequence), T_map_truth));

  const Walker walker;
  std::vector<ResultPose> poses = result.trajectory;
  const auto start = EndOf(query, walker, poses);
  std::reverse(poses.begin(), poses.end());
  const auto goal = EndOf(query, walker, poses);
  std::vector<Footstep> steps;
  if (start && goal) steps = PlanFootsteps(query, walker, *start, *goal);
  int num_right = 0;
  for (const Footstep& step : steps) num_right += IsRightFoothold(truth, step.ground, walker.foot.radius_m);
  ++counts->num_places;
  counts->num_reached += !steps.empty();
  counts->num_placements += static_cast<int>(steps.size());
  counts->num_right += num_right;
  const double way_m = start && goal ? (goal->ground_world - start->ground_world).norm() : 0.0;
  std::printf("%-40s %s, %.1f m, %d of %zu placements right\n", result_folder.c_str(),
              steps.empty() ? "no way" : "reached", way_m, num_right, steps.size());
  std::ofstream(result_folder / "footsteps.svg") << PlanPicture(*map, steps, walker.foot.radius_m);
}

int Run(int argc, char** argv) {
  PlanCounts counts;
  for (int i = 1; i + 1 < argc; i += 2) Judge(argv[i], argv[i + 1], &counts);
  std::printf("{\"places\": %d, \"reached\": %d, \"placements\": %d, \"right_percent\": %.2f}\n",
              counts.num_places, counts.num_reached, counts.num_placements,
              100.0 * counts.num_right / std::max(1, counts.num_placements));
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) { return terrace::Run(argc, argv); }
