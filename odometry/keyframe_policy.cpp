// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/keyframe_policy.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace terrace {
namespace {

/// Without the right image a keyframe would make no landmarks, and drive out an old one that has some.
bool SeesWithBoth(const PoseFinder::Found& found) {
  constexpr double kMinShare = 0.02;
  int with_disparity = 0;
  for (std::size_t i = 0; i < found.matches.size(); ++i)
    with_disparity += found.solution.inlier[i] && found.matches[i].measurement.has_disparity;
  return with_disparity >= kMinShare * found.solution.num_inliers;
}

}  // namespace

bool KeyframePolicy::Wants(const Window& window, const ImagePyramid& left, const PoseFinder::Found& found,
                           bool with_imu, double age_s) {
  return Needs(window, found, with_imu, age_s) && SeesWithBoth(found) && !WaitForCertainty(found) &&
         !WaitForSharperImage(left);
}

void KeyframePolicy::NoteMade(bool rests, double covered_cells) {
  keyframes_at_rest_ = rests ? keyframes_at_rest_ + 1 : 0;
  covered_cells_ = covered_cells;
}

bool KeyframePolicy::Needs(const Window& window, const PoseFinder::Found& found, bool with_imu,
                           double age_s) const {
  const PoseSolution& solution = found.solution;
  const Keyframe& newest = window.keyframes.back();
  const double distance = (solution.T_world_left.translation() - newest.T_world_left.translation()).norm();
  std::vector<bool> held(static_cast<std::size_t>(grid_.num_cells()), false);
  std::vector<double> inverse_depths;
  for (std::size_t i = 0; i < found.matches.size(); ++i) {
    if (!solution.inlier[i]) continue;
    const Match& match = found.matches[i];
    held[static_cast<std::size_t>(grid_.CellOf(match.measurement.uvd.x(), match.measurement.uvd.y()))] = true;
    inverse_depths.push_back(match.predicted.uvd.z() / (camera_.fx * camera_.baseline_m));
  }
  const double coverage = static_cast<double>(std::count(held.begin(), held.end(), true)) / covered_cells_;
  if (coverage < config_.keyframe_min_coverage) return true;
  auto middle = inverse_depths.begin() + static_cast<std::ptrdiff_t>(inverse_depths.size() / 2);
  std::nth_element(inverse_depths.begin(), middle, inverse_depths.end());
  if (distance * *middle > config_.keyframe_parallax) return true;
  // At rest gravity and biases show without parallax; a few keyframes are enough, more would only drift.
  constexpr double kPeriod_s = 1.0;
  return with_imu && keyframes_at_rest_ < config_.window_keyframes - 2 && age_s > kPeriod_s;
}

/// Nothing is built on a pose in doubt, unless the doubt goes on.
bool KeyframePolicy::WaitForCertainty(const PoseFinder::Found& found) {
  constexpr int kPatience = 4;  // frames
  num_doubtful_ = found.doubt ? num_doubtful_ + 1 : 0;
  return found.doubt && num_doubtful_ <= kPatience;
}

/// A blurred keyframe would blur all that is found with its texture: better a later one, unless that goes on.
bool KeyframePolicy::WaitForSharperImage(const ImagePyramid& left) {
  constexpr double kBlurred = 0.65;  // of the usual sharpness
  constexpr double kRate = 0.2;
  constexpr int kPatience = 4;  // frames
  const double sharpness = Sharpness(left);
  const bool blurred = sharpness < kBlurred * usual_sharpness_;
  usual_sharpness_ += kRate * (sharpness - usual_sharpness_);
  num_waited_ = blurred ? num_waited_ + 1 : 0;
  return blurred && num_waited_ <= kPatience;
}

}  // namespace terrace
