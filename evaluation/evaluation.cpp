// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/file_bytes.h"
#include "core/print.h"
#include "datasets/ground_truth.h"
#include "evaluation/disparity_picture.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

/// Slope of y over x by least squares; 0 when x does not change.
double Slope(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double mean_x = 0.0, mean_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / n;
    mean_y += y[i] / n;
  }
  double xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  return xx > 0.0 ? xy / xx : 0.0;
}

std::optional<LatencyGrowth> GrowthOf(const std::vector<ResultFrame>& frames) {
  std::vector<double> latencies_ms, cells, regions;
  for (const ResultFrame& frame : frames) {
    if (!frame.latency_ms) continue;
    latencies_ms.push_back(*frame.latency_ms);
    cells.push_back(1e-3 * static_cast<double>(frame.map_cells));
    regions.push_back(1e-2 * static_cast<double>(frame.regions));
  }
  if (latencies_ms.empty()) return std::nullopt;
  return LatencyGrowth{static_cast<int>(latencies_ms.size()), Slope(cells, latencies_ms),
                       Slope(regions, latencies_ms)};
}

void KeepExample(Timestamp t_capture, const FloatImage& disparity_px, const DisparityTruth& truth,
                 DisparityEvaluation* evaluation) {
  DisparityErrors errors;
  errors.Add(disparity_px, truth);
  const double bad_pct = errors.bad_all_pct(1.0);
  if (!evaluation->best || bad_pct < evaluation->best->bad1_all_pct)
    evaluation->best = {t_capture, bad_pct, PictureOfErrors(disparity_px, truth)};
  if (!evaluation->worst || bad_pct > evaluation->worst->bad1_all_pct)
    evaluation->worst = {t_capture, bad_pct, PictureOfErrors(disparity_px, truth)};
}

/// Disparity images of the result that have a true depth image and a true pose of the same moment.
std::optional<DisparityEvaluation> EvaluateDisparities(const ReplayResult& result, const fs::path& sequence,
                                                       const TrueScene& scene,
                                                       const std::vector<TimedPose>& true_left,
                                                       std::vector<std::string>* notes) {
  const std::map<Timestamp, fs::path> saved = SavedDisparities(result.folder);
  const std::map<Timestamp, fs::path> depths = TrueDepthImages(sequence);
  if (saved.empty() || depths.empty()) return std::nullopt;
  if (!TrueImagesApply(result.camera)) {
    notes->push_back("disparity: rectification turns the camera, so the true depth images do not apply");
    return std::nullopt;
  }
  const std::map<Timestamp, fs::path> labels = TrueLabelImages(sequence);
  DisparityEvaluation evaluation;
  for (const auto& [t, path] : saved) {
    const auto depth = depths.find(t);
    const std::vector<PosePair> pose = MatchPoses({{t, Eigen::Isometry3d::Identity()}}, true_left);
    if (depth == depths.end() || pose.empty()) continue;
    const auto label = labels.find(t);
    const Eigen::Isometry3d& T_world_left = pose.front().T_true_left;
    const StereoCamera& camera = result.camera.camera;
    const RenderedTruth truth =
        LoadRenderedTruth(depth->second, label == labels.end() ? std::nullopt : std::optional(label->second),
                          scene, camera, T_world_left);
    const FloatImage disparity_px = ReadDisparityFile(path);
    evaluation.errors.Add(disparity_px, truth.disparity);
    ++evaluation.num_images;
    KeepExample(t, disparity_px, truth.disparity, &evaluation);
    const std::vector<PlaneFit> planes = FitPlanes(disparity_px, truth, scene, camera, T_world_left);
    evaluation.planes.insert(evaluation.planes.end(), planes.begin(), planes.end());
    const std::vector<EdgeFit> edges = FitEdges(disparity_px, truth, scene, camera, T_world_left);
    evaluation.edges.insert(evaluation.edges.end(), edges.begin(), edges.end());
  }
  if (evaluation.num_images == 0) {
    notes->push_back("disparity: no saved image has a true depth image of the same time");
    return std::nullopt;
  }
  return evaluation;
}

/// Poses of different worlds have nothing to do with each other: those of each world, the first one first.
std::vector<std::vector<PosePair>> ByEpoch(const std::vector<PosePair>& pairs,
                                           const std::vector<ResultFrame>& frames) {
  std::map<Timestamp, int> epochs;
  for (const ResultFrame& frame : frames) epochs[frame.t_capture] = frame.epoch;
  std::map<int, std::vector<PosePair>> sorted;
  for (const PosePair& pair : pairs) {
    const auto epoch = epochs.find(pair.t);
    sorted[epoch == epochs.end() ? 0 : epoch->second].push_back(pair);
  }
  std::vector<std::vector<PosePair>> all;
  for (auto& [epoch, of_epoch] : sorted) all.push_back(std::move(of_epoch));
  return all;
}

}  // namespace

Evaluation EvaluateResult(const fs::path& result_folder, const fs::path& sequence,
                          const MapEvaluationOptions& options) {
  if (!fs::exists(sequence)) throw FileError(sequence.string() + ": no such sequence");
  const ReplayResult result = ReadReplayResult(result_folder);
  Evaluation evaluation;
  evaluation.result = result_folder;
  evaluation.sequence = sequence;
  evaluation.stats = result.stats;
  evaluation.frames = result.frames;
  evaluation.film = LoadFilm(result_folder);
  evaluation.result_map = result.map;
  evaluation.regions = CountRegions(result.map);
  evaluation.consistency = EvaluateConsistency(result, sequence);
  evaluation.latency_growth = GrowthOf(result.frames);

  std::vector<TimedPose> true_left;
  std::vector<PosePair> pairs;
  if (HasTrueTrajectory(sequence)) {
    true_left = TrueLeftPoses(LoadTrueTrajectory(sequence), result.camera);
    pairs = MatchPoses(result.trajectory, true_left);
    const std::vector<std::vector<PosePair>> worlds = ByEpoch(pairs, result.frames);
    if (worlds.size() > 1) {
      const auto shorter = [](const auto& a, const auto& b) { return a.size() < b.size(); };
      evaluation.notes.push_back(Printed(
          "%zu worlds: the trajectory is that of the longest, the map the last one's", worlds.size()));
      pairs = *std::max_element(worlds.begin(), worlds.end(), shorter);
    }
    evaluation.trajectory =
        EvaluateTrajectory(pairs, result.frames, static_cast<std::int64_t>(true_left.size()),
                           result.stats.frames + result.stats.dropped);
    if (pairs.empty()) {
      evaluation.trajectory.reset();
      evaluation.notes.push_back(result.trajectory.empty()
                                     ? "trajectory: not measured, for the result has no poses"
                                     : "trajectory: not measured, for " +
                                           WhyNoneMatches(result.trajectory, true_left));
    }
    if (!worlds.empty()) pairs = worlds.back();
  } else {
    evaluation.notes.push_back("trajectory: the sequence has no true poses");
  }

  if (!HasTrueScene(sequence)) {
    evaluation.notes.push_back("map: the sequence has no true scene");
    return evaluation;
  }
  evaluation.scene = LoadTrueScene(sequence);
  const TrueScene& scene = evaluation.scene;
  if (pairs.empty()) {
    evaluation.notes.push_back("map: not measured, for there is no pose to move it onto the truth by");
    return evaluation;
  }
  const Eigen::Isometry3d T_true_result = AlignByOrientations(pairs);
  evaluation.map = EvaluateMap(result.map, scene, T_true_result, options);
  const std::optional<CellsOfPolygons> well_seen =
      LoadWellSeenCells(sequence, scene, result.camera, true_left);
  if (!well_seen)
    evaluation.notes.push_back("feet: what was well seen is not known, for no label image is of this camera");
  evaluation.feet = EvaluateFeet(result.map, scene, well_seen.value_or(CellsOfPolygons{}), T_true_result);
  evaluation.staircases =
      EvaluateStaircases(result.map.staircases, result.staircase_reports, scene, T_true_result, true_left);
  evaluation.disparity = EvaluateDisparities(result, sequence, scene, true_left, &evaluation.notes);
  return evaluation;
}

}  // namespace terrace
