// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/summary.h"

#include <array>
#include <cstdio>
#include <exception>

#include "datasets/ground_truth.h"
#include "evaluation/trajectory_evaluation.h"
#include "results/camera_file.h"
#include "results/trajectory_file.h"

namespace terrace {
namespace {

// A long outage must not fill the screen; frames.jsonl holds every frame.
constexpr std::size_t kMaxTroubles = 10;

/// How far the trajectory left the truth, when the sequence has one.
void PrintDrift(const std::filesystem::path& sequence, const std::filesystem::path& output) {
  if (!HasTrueTrajectory(sequence)) return;
  try {
    const std::vector<TimedPose> truth =
        TrueLeftPoses(LoadTrueTrajectory(sequence), ReadCameraFile(output / "camera.json"));
    const std::vector<ResultPose> poses = ReadTrajectoryFile(output / "trajectory.tum");
    const std::vector<PosePair> pairs = MatchPoses(poses, truth);
    if (pairs.empty()) {
      std::printf("drift        not measured: %s\n",
                  poses.empty() ? "no frame was tracked" : WhyNoneMatches(poses, truth).c_str());
      return;
    }
    const TrajectoryEvaluation drift = EvaluateTrajectory(pairs, {}, static_cast<std::int64_t>(truth.size()),
                                                          static_cast<std::int64_t>(pairs.size()));
    std::printf("drift        %.1f mm rms over %.1f m", 1e3 * drift.ate_rmse_m, drift.path_length_m);
    if (const SegmentError* metre = drift.Segment(1.0))
      std::printf(", %.2f %% over 1 m", metre->translation_pct);
    if (const SegmentError* ten = drift.Segment(10.0))
      std::printf(", %.2f %% over 10 m", ten->translation_pct);
    std::printf("\n");
  } catch (const std::exception& error) {
    std::printf("drift        not known: %s\n", error.what());
  }
}

void PrintMap(const TerrainMap& map) {
  std::array<int, kNumTerrainLabels> counts{};
  std::array<double, kNumTerrainLabels> areas_m2{};
  for (const auto& region : map.regions) {
    ++counts[static_cast<std::size_t>(region->label)];
    areas_m2[static_cast<std::size_t>(region->label)] += region->area_m2;
  }
  std::printf("map          %zu polygons\n", map.regions.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    std::printf("             %-12s %4d, %7.2f m2\n", Name(static_cast<TerrainLabel>(i)), counts[i],
                areas_m2[i]);
  }
  std::printf("staircases   %zu\n", map.staircases.size());
  for (const Staircase& staircase : map.staircases) {
    std::printf("             %lld: %d risers of %.3f m, treads of %.3f m, %.2f m wide, confidence %.2f\n",
                static_cast<long long>(staircase.id), staircase.num_risers, staircase.riser_m,
                staircase.tread_m, staircase.width_m, staircase.confidence);
  }
}

}  // namespace

void RunSummary::AddFrame(const FrameResult& result) {
  const PoseEstimate& pose = result.pose;
  if (pose.status != last_status_ && troubles_.size() < kMaxTroubles) {
    std::array<char, 64> time{};
    std::snprintf(time.data(), time.size(), "%.3f s: ", Seconds(pose.t_capture - info_.t_first));
    troubles_.push_back(time.data() + std::string(Name(pose.status)) +
                        (pose.reason.empty() ? "" : ", " + pose.reason));
  }
  last_status_ = pose.status;
}

void RunSummary::Print(const ResultWriter& writer, const RunTotals& totals,
                       const std::filesystem::path& output) const {
  std::printf("sequence     %s (%s)\n", info_.path.string().c_str(), Name(info_.kind));
  std::printf("frames       %lld: %lld tracking, %lld bridging, %lld lost; %lld dropped\n",
              static_cast<long long>(writer.num_frames()), static_cast<long long>(writer.num_tracking()),
              static_cast<long long>(writer.num_bridging()), static_cast<long long>(writer.num_lost()),
              static_cast<long long>(totals.num_dropped));
  for (const std::string& trouble : troubles_) std::printf("             at %s\n", trouble.c_str());
  PrintDrift(info_.path, output);
  std::printf("rate         %.1f frames/s\n",
              totals.wall_s > 0 ? static_cast<double>(writer.num_frames()) / totals.wall_s : 0.0);
  for (const StageCost& stage : totals.stages) {
    if (stage.count == 0) continue;
    std::printf("             %-14s %7.2f ms CPU, %7.2f ms p50, %7.2f ms p99\n", stage.name.c_str(),
                stage.cpu_ms_mean, stage.wall_ms.p50, stage.wall_ms.p99);
  }
  PrintMap(*writer.map());
  std::printf("results      %s\n", output.string().c_str());
}

}  // namespace terrace
