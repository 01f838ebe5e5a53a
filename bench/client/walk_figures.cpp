// SPDX-License-Identifier: BSD-3-Clause
// How well a planner is served while the robot walks: plays logs of the bus of places whose truth is known,
// and at every fifth pose asks the map as it had been received by then for footholds 0.25 to 1.0 m ahead of
// the camera, to the left and right of its way. Asked for is only what truth offers, once the camera has gone
// 1 m. What is not offered is asked for again with treads that were inferred and never seen, and then without
// distances from edges, to say what is missing. Arguments: result, log and sequence in turn, of `terraced
// replay SEQUENCE --output RESULT --publish "file:///LOG?mode=w"`. The last line is one JSON object.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>
#include <terrace/pose_v1_t.hpp>

#include "bench/client/true_ground.h"
#include "client/terrain_follower.h"
#include "client/terrain_query.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/safe_decode.h"
#include "results/replay_result.h"

namespace terrace {
namespace {

constexpr int kAskEvery = 5;
constexpr double kBeforeAsking_m = 1.0;
constexpr double kReach_m = 0.12;
constexpr std::array kAhead_m{0.25, 0.4, 0.55, 0.7, 0.85, 1.0};
constexpr std::array kAside_m{-0.1, 0.1};

struct WalkCounts {
  int num_asked = 0;
  int num_offered = 0;
  int num_right = 0;
  int num_predicted = 0;  // offered on what was inferred and never seen
  int num_predicted_right = 0;
  int num_at_edges = 0;  // on seen ground, and refused for its edges

  void Add(const WalkCounts& other) {
    num_asked += other.num_asked;
    num_offered += other.num_offered;
    num_right += other.num_right;
    num_predicted += other.num_predicted;
    num_predicted_right += other.num_predicted_right;
    num_at_edges += other.num_at_edges;
  }
};

/// Where truth has ground for a foot.
void AskAt(const Eigen::Vector3d& p_world, const TerrainQuery& query, const TerrainQuery& truth,
           WalkCounts* counts) {
  const FootSpec foot;
  FootSpec inferred = foot, anywhere = foot;
  inferred.allow_predicted = true;
  anywhere.clear_drop_m = anywhere.clear_rise_m = 0.0;
  const auto ask = [&](const FootSpec& spec) {
    return query.NearestFoothold(p_world, kReach_m, kReach_m, spec);
  };
  const auto is_right = [&](const Foothold& foothold) {
    return IsRightFoothold(truth, foothold.support, foot.radius_m);
  };
  ++counts->num_asked;
  if (const auto foothold = ask(foot)) {
    ++counts->num_offered;
    counts->num_right += is_right(*foothold);
  } else if (const auto predicted = ask(inferred)) {
    ++counts->num_predicted;
    counts->num_predicted_right += is_right(*predicted);
  } else if (ask(anywhere)) {
    ++counts->num_at_edges;
  }
}

WalkCounts AskAhead(const TerrainQuery& query, const TerrainQuery& truth,
                    const Eigen::Isometry3d& T_world_left) {
  const Eigen::Vector2d ahead = T_world_left.linear().col(2).head<2>().normalized();
  const Eigen::Vector2d aside(-ahead.y(), ahead.x());
  const Eigen::Vector3d& eye = T_world_left.translation();
  WalkCounts counts;
  for (const double ahead_m : kAhead_m) {
    for (const double aside_m : kAside_m) {
      const Eigen::Vector2d xy = eye.head<2>() + ahead_m * ahead + aside_m * aside;
      const auto ground = truth.SupportAt(xy, eye.z() - 1.5, eye.z());
      if (ground && truth.NearestFoothold(ground->point_world, kReach_m, kReach_m, FootSpec()))
        AskAt(ground->point_world, query, truth, &counts);
    }
  }
  return counts;
}

/// None: it was lost then.
std::optional<Eigen::Isometry3d> CameraAt(const ReplayResult& result, std::int64_t t_capture_ns) {
  for (const ResultPose& pose : result.trajectory)
    if (pose.t_capture.ns == t_capture_ns) return pose.T_world_left;
  return std::nullopt;
}

WalkCounts Walk(const std::filesystem::path& result_folder, const std::string& log_path,
                const std::filesystem::path& sequence) {
  const ReplayResult result = ReadReplayResult(result_folder);
  const TrueTrajectory trajectory = LoadTrueTrajectory(sequence);
  const Eigen::Isometry3d T_map_truth =
      result.trajectory.front().T_world_left * trajectory.poses.front().T_world_frame.inverse();
  const TerrainQuery truth(TrueGround(LoadTrueScene(sequence), T_map_truth));
  const ChannelConfig channels;
  lcm::LogFile log(log_path, "r");
  TerrainFollower follower;
  std::optional<TerrainQuery> query;
  WalkCounts counts;
  int num_poses = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    if (event->channel == channels.terrain)
      follower.Receive(event->data, static_cast<std::size_t>(event->datalen));
    if (event->channel != channels.pose_state || ++num_poses % kAskEvery != 0 || !follower.map()) continue;
    const auto message = SafeDecode<pose_v1_t>(event->data, static_cast<std::size_t>(event->datalen));
    const auto T_world_left = message ? CameraAt(result, message->t_capture_ns) : std::nullopt;
    if (!T_world_left) continue;
    const Eigen::Vector3d way =
        T_world_left->translation() - result.trajectory.front().T_world_left.translation();
    if (way.norm() < kBeforeAsking_m) continue;
    query.emplace(follower.map());
    counts.Add(AskAhead(*query, truth, *T_world_left));
  }
  std::printf("%-40s asked %d, offered %d, right %d; on predicted ground %d, right %d; too near edges %d\n",
              result_folder.c_str(), counts.num_asked, counts.num_offered, counts.num_right,
              counts.num_predicted, counts.num_predicted_right, counts.num_at_edges);
  return counts;
}

double Percent(int part, int whole) { return 100.0 * part / std::max(1, whole); }

int RunWalks(int argc, char** argv) {
  WalkCounts all;
  for (int i = 1; i + 2 < argc; i += 3) all.Add(Walk(argv[i], argv[i + 1], argv[i + 2]));
  std::printf(
      "{\"asked\": %d, \"offered_percent\": %.2f, \"right_percent\": %.2f, \"predicted_percent\": %.2f, "
      "\"predicted_right_percent\": %.2f, \"at_edges_percent\": %.2f}\n",
      all.num_asked, Percent(all.num_offered, all.num_asked), Percent(all.num_right, all.num_offered),
      Percent(all.num_predicted, all.num_asked), Percent(all.num_predicted_right, all.num_predicted),
      Percent(all.num_at_edges, all.num_asked));
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) { return terrace::RunWalks(argc, argv); }
