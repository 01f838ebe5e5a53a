// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/yardstick.h"

#include <map>
#include <optional>
#include <vector>

#include "core/file_bytes.h"
#include "core/print.h"
#include "datasets/ground_truth.h"
#include "evaluation/alignment.h"
#include "evaluation/disparity_file.h"
#include "evaluation/elevation_map.h"
#include "evaluation/trajectory_evaluation.h"
#include "evaluation/well_seen.h"
#include "results/replay_result.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

void PrintRow(const char* name, const std::optional<double>& ours, const std::optional<double>& other,
              std::string* text) {
  Print(text, "%-24s", name);
  for (const std::optional<double>& value : {ours, other}) {
    if (value) Print(text, " %13.2f", *value);
    if (!value) Print(text, " %13s", "-");
  }
  *text += "\n";
}

}  // namespace

Yardstick EvaluateYardstick(const fs::path& result_folder, const fs::path& sequence) {
  const ReplayResult result = ReadReplayResult(result_folder);
  const std::map<Timestamp, fs::path> disparities = SavedDisparities(result_folder);
  if (disparities.empty())
    throw FileError(result_folder.string() + ": has no disparity images; replay with --save-disparity 1");
  const TrueScene scene = LoadTrueScene(sequence);
  const std::vector<TimedPose> true_left = TrueLeftPoses(LoadTrueTrajectory(sequence), result.camera);
  const std::vector<PosePair> pairs = MatchPoses(result.trajectory, true_left);
  if (pairs.empty()) throw FileError(result_folder.string() + ": no pose has a true one within 2 ms");
  const auto well_seen = LoadWellSeenCells(sequence, scene, result.camera, true_left);
  if (!well_seen) throw FileError(sequence.string() + ": has no label images of this camera");
  const Eigen::Isometry3d T_true_result = AlignByOrientations(pairs);

  Yardstick yardstick;
  ElevationMap map;
  for (const ResultPose& pose : result.trajectory) {
    const auto image = disparities.find(pose.t_capture);
    if (image == disparities.end()) continue;
    map.Add(ReadDisparityFile(image->second), result.camera.camera, T_true_result * pose.T_world_left);
    ++yardstick.num_images;
  }
  map.FindFootholds();
  yardstick.ours = EvaluateFeet(result.map, scene, *well_seen, T_true_result);
  yardstick.elevation_map = EvaluateFootholds(map, scene, *well_seen);
  return yardstick;
}

std::string ToTable(const Yardstick& yardstick) {
  const FeetEvaluation& a = yardstick.ours;
  const FeetEvaluation& b = yardstick.elevation_map;
  std::string text;
  Print(&text, "%-24s %13s %13s  (of %d disparity images)\n", "feet", "regions", "elevation map",
        yardstick.num_images);
  PrintRow("footholds m2", a.foothold_m2, b.foothold_m2, &text);
  PrintRow("unsupported %", a.unsupported_pct(), b.unsupported_pct(), &text);
  PrintRow("  near drops cm2", 1e4 * a.unsupported_drop_m2, 1e4 * b.unsupported_drop_m2, &text);
  PrintRow("offered %", a.offered_pct(), b.offered_pct(), &text);
  PrintRow("treads offered, mean %", a.tread_offered_pct(), b.tread_offered_pct(), &text);
  PrintRow("treads offered, worst %", a.tread_offered_min_pct(), b.tread_offered_min_pct(), &text);
  return text;
}

}  // namespace terrace
