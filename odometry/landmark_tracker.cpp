// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/landmark_tracker.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "odometry/patch.h"
#include "odometry/patch_alignment.h"

namespace terrace {
namespace {

/// Outside this range of sizes the host's texture no longer looks like what is seen.
constexpr double kMinScale = 0.4;
constexpr double kMaxScale = 2.5;
/// Share of the variance a found patch must explain.
constexpr float kMinAgreement = 0.7f;
constexpr double kPixelFloorPx = 0.05;

/// The host's level on which a pixel is about as large as one on a level here.
int HostLevel(const Match& match, int level) {
  const int shift = static_cast<int>(std::lround(-std::log2(match.scale)));
  return std::clamp(level + shift, 0, ImagePyramid::kNumLevels - 1);
}

}  // namespace

LandmarkTracker::LandmarkTracker(const StereoCamera& camera, const FeatureGrid& grid)
    : camera_(camera), grid_(grid) {}

std::vector<Match> LandmarkTracker::Candidates(const Window& window, const Eigen::Isometry3d& T_world_left,
                                               int max_per_cell) const {
  std::vector<Eigen::Isometry3d> T_left_host;
  for (const Keyframe& keyframe : window.keyframes)
    T_left_host.push_back(T_world_left.inverse() * keyframe.T_world_left);

  struct Candidate {
    Match match;
    double rank = 0.0;
    int cell = 0;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < window.landmarks.size(); ++i) {
    const Landmark& landmark = window.landmarks[i];
    Candidate candidate;
    Match& match = candidate.match;
    match.landmark = static_cast<int>(i);
    const auto host = static_cast<std::size_t>(landmark.host - window.keyframes.front().id);
    if (!Project(landmark, T_left_host[host], camera_, match.predicted)) continue;
    const Eigen::Vector3d& uvd = match.predicted.uvd;
    if (uvd.x() < 0 || uvd.y() < 0 || uvd.x() > camera_.width - 1 || uvd.y() > camera_.height - 1) continue;
    match.scale = std::sqrt(match.predicted.A_here_host.determinant());
    if (match.scale < kMinScale || match.scale > kMaxScale) continue;
    // Seen from nearly the same place and often before: most likely to be found, and known best.
    candidate.rank = std::min<double>(landmark.num_tracked, 10.0) * 0.1 - std::abs(std::log2(match.scale)) -
                     0.5 * landmark.num_failures;
    candidate.cell = grid_.CellOf(uvd.x(), uvd.y());
    candidates.push_back(std::move(candidate));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.rank > b.rank; });

  std::vector<int> taken(static_cast<std::size_t>(grid_.num_cells()), 0);
  std::vector<Match> chosen;
  for (const Candidate& candidate : candidates)
    if (taken[static_cast<std::size_t>(candidate.cell)]++ < max_per_cell) chosen.push_back(candidate.match);
  return chosen;
}

Matches LandmarkTracker::Track(const Window& window, const ImagePyramid& left, const ImagePyramid& right,
                               const Eigen::Isometry3d& T_world_left, double vertical_px,
                               const SearchOptions& options) const {
  Matches matches;
  std::vector<Match> candidates = Candidates(window, T_world_left, options.max_per_cell);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    // Keyframes are too large for the processor's cache, and landmarks lie scattered over them.
    constexpr std::size_t kAhead = 2;
    if (i + kAhead < candidates.size()) Prefetch(window, candidates[i + kAhead], options);
    Match& match = candidates[i];
    const Landmark& landmark = window.landmarks[static_cast<std::size_t>(match.landmark)];
    matches.NoteTried(match.landmark, landmark);
    if (!FindInLeft(landmark, window.at(landmark.host).left, left, options, match)) continue;
    if (options.use_right && match.level == 0) FindInRight(left, right, vertical_px, match);
    matches.found.push_back(match);
  }
  return matches;
}

Matches LandmarkTracker::SearchWide(const Window& window, const ImagePyramid& left,
                                    const Eigen::Isometry3d& T_world_left, double reach_px, int level) const {
  const auto scale = static_cast<float>(1 << level);
  const int stride = level >= 3 ? 1 : 2;  // patches are smooth, and the pose finds the rest
  constexpr int kBlockCells = 2;
  constexpr float kMinCorrelation = 0.8f;
  constexpr double kSigmaPx = 0.75;  // of the level: whole pixels, and patches that look a little different
  const cv::Mat1b& image = left[level];
  const auto reach = static_cast<int>(std::min<double>(reach_px / scale, image.cols));
  const int block_columns = grid_.columns / kBlockCells + 1;
  std::vector<bool> taken(static_cast<std::size_t>(block_columns * (grid_.rows / kBlockCells + 1)), false);
  Matches matches;
  for (Match& match : Candidates(window, T_world_left, 1)) {
    const int cell = grid_.CellOf(match.predicted.uvd.x(), match.predicted.uvd.y());
    const auto block = static_cast<std::size_t>(cell / grid_.columns / kBlockCells * block_columns +
                                                cell % grid_.columns / kBlockCells);
    if (taken[block]) continue;
    taken[block] = true;
    const Landmark& landmark = window.landmarks[static_cast<std::size_t>(match.landmark)];
    matches.NoteTried(match.landmark, landmark);
    const Eigen::Matrix2f A_host_here = match.predicted.A_here_host.inverse().cast<float>();
    PatchTemplate patch;
    if (!ExtractTemplate(window.at(landmark.host).left[level], landmark.pixel_host.cast<float>() / scale,
                         A_host_here, patch))
      continue;
    const Eigen::Vector2d first_sample =
        match.predicted.uvd.head<2>() / scale + Eigen::Vector2d::Constant(PatchTemplate::Offset(0));
    const Eigen::Vector2i expected = first_sample.array().round().cast<int>();
    const int u_end = std::min(expected.x() + reach, image.cols - PatchTemplate::kSize);
    const int v_end = std::min(expected.y() + reach, image.rows - PatchTemplate::kSize);
    float best = kMinCorrelation;
    for (int v = std::max(expected.y() - reach, 0); v <= v_end; v += stride) {
      for (int u = std::max(expected.x() - reach, 0); u <= u_end; u += stride) {
        const float correlation = Correlation(image, patch, u, v);
        if (correlation <= best) continue;
        best = correlation;
        match.measurement.uvd << (u - PatchTemplate::Offset(0)) * scale,
            (v - PatchTemplate::Offset(0)) * scale, 0.0;
      }
    }
    if (best <= kMinCorrelation) continue;
    match.level = level;
    match.measurement.covariance_uv = Eigen::Matrix2d::Identity() * (kSigmaPx * kSigmaPx * scale * scale);
    matches.found.push_back(match);
  }
  return matches;
}

void LandmarkTracker::Prefetch(const Window& window, const Match& match, const SearchOptions& options) const {
  const Landmark& landmark = window.landmarks[static_cast<std::size_t>(match.landmark)];
  const ImagePyramid& host = window.at(landmark.host).left;
  for (int level = options.start_level; level >= options.finest_level; --level) {
    const int host_level = HostLevel(match, level);
    PrefetchTemplate(host[host_level],
                     landmark.pixel_host.cast<float>() / static_cast<float>(1 << host_level));
  }
}

bool LandmarkTracker::FindInLeft(const Landmark& landmark, const ImagePyramid& host, const ImagePyramid& left,
                                 const SearchOptions& options, Match& match) const {
  constexpr int kMaxIterations = 8;
  constexpr float kMaxShiftPx = 8.0f;        // on the level searched
  constexpr float kMaxShiftFinestPx = 4.0f;  // after a coarser level has agreed
  const Eigen::Matrix2f A_host_here = match.predicted.A_here_host.inverse().cast<float>();
  Eigen::Vector2f position = match.predicted.uvd.head<2>().cast<float>();

  PatchTemplate patch;
  Alignment alignment;
  int found_level = -1;
  for (int level = options.start_level; level >= options.finest_level; --level) {
    const int host_level = HostLevel(match, level);
    const float here = static_cast<float>(1 << level);
    const float there = static_cast<float>(1 << host_level);
    if (!ExtractTemplate(host[host_level], landmark.pixel_host.cast<float>() / there,
                         A_host_here * (here / there), patch))
      continue;
    const float max_shift = level == 0 && found_level > 0 ? kMaxShiftFinestPx : kMaxShiftPx;
    if (!Align(left[level], patch, position / here, kMaxIterations, max_shift, alignment) ||
        alignment.agreement < kMinAgreement)
      continue;
    position = alignment.position * here;
    found_level = level;
    match.measurement.covariance_uv =
        alignment.covariance.cast<double>() * (here * here) +
        Eigen::Matrix2d::Identity() * (kPixelFloorPx * kPixelFloorPx * here * here);
  }
  constexpr int kCoarsestUseful = 2;
  if (found_level < 0 || found_level > kCoarsestUseful) return false;
  match.level = found_level;
  match.measurement.uvd << position.cast<double>(), 0.0;
  return true;
}

void LandmarkTracker::FindInRight(const ImagePyramid& left, const ImagePyramid& right, double vertical_px,
                                  Match& match) const {
  constexpr int kMaxIterations = 8;
  constexpr float kMaxShiftPx = 5.0f;
  constexpr double kMaxVerticalErrorPx = 1.0;
  // Offset (i, j) in the right image lies at ((i + b j) / (1 - a), j) in the left one.
  const Eigen::Vector2d slant = match.predicted.disparity_gradient;
  if (!(slant.x() < 0.8 && slant.x() > -2.0)) return;
  Eigen::Matrix2f A_left_right;
  A_left_right << static_cast<float>(1.0 / (1.0 - slant.x())),
      static_cast<float>(slant.y() / (1.0 - slant.x())), 0.0f, 1.0f;
  PatchTemplate patch;
  const Eigen::Vector2f uv = match.measurement.uvd.head<2>().cast<float>();
  if (!ExtractTemplate(left[0], uv, A_left_right, patch)) return;
  Alignment alignment;
  const Eigen::Vector2f start(uv.x() - static_cast<float>(match.predicted.uvd.z()),
                              uv.y() + static_cast<float>(vertical_px));
  if (!Align(right[0], patch, start, kMaxIterations, kMaxShiftPx, alignment) ||
      alignment.agreement < kMinAgreement)
    return;
  match.found_in_right = true;
  match.vertical_px = alignment.position.y() - uv.y();
  if (std::abs(match.vertical_px - vertical_px) > kMaxVerticalErrorPx) return;
  match.measurement.uvd.z() = uv.x() - alignment.position.x();
  match.measurement.sigma_d = std::sqrt(alignment.covariance(0, 0) + kPixelFloorPx * kPixelFloorPx);
  match.measurement.has_disparity = true;
}

}  // namespace terrace
