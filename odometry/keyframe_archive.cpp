// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/keyframe_archive.h"

#include <algorithm>

#include "odometry/covariance.h"
#include "odometry/place_recognition.h"
#include "odometry/rotation.h"

namespace terrace {

KeyframeArchive::KeyframeArchive(const StereoCamera& camera, int max_keyframes)
    : camera_(camera), max_keyframes_(static_cast<std::size_t>(max_keyframes)) {}

void KeyframeArchive::Add(const Keyframe& keyframe, const std::vector<Landmark>& landmarks,
                          const Matrix6d& covariance) {
  ArchivedKeyframe kept;
  kept.id = keyframe.id;
  kept.frame_id = keyframe.frame_id;
  kept.t_capture = keyframe.t_capture;
  kept.T_world_left = keyframe.T_world_left;
  kept.covariance = covariance;
  for (const Landmark& landmark : landmarks) {
    constexpr double kMinTrust = 0.35;
    if (landmark.host != keyframe.id || landmark.trust() < kMinTrust) continue;
    if (const auto descriptor = Describe(keyframe.left, landmark.pixel_host))
      kept.points.push_back({landmark.ray_host / landmark.inverse_depth, *descriptor});
  }
  const auto same = std::find_if(keyframes_.begin(), keyframes_.end(),
                                 [&](const ArchivedKeyframe& other) { return other.id == kept.id; });
  if (same != keyframes_.end()) {
    *same = std::move(kept);
    return;
  }
  keyframes_.push_back(std::move(kept));
  if (keyframes_.size() <= max_keyframes_) return;
  // Every second one of the older half goes: the past stays covered, only less densely.
  std::vector<ArchivedKeyframe> thinned;
  for (std::size_t i = 0; i < keyframes_.size(); ++i)
    if (i % 2 == 0 || i >= keyframes_.size() / 2) thinned.push_back(std::move(keyframes_[i]));
  keyframes_ = std::move(thinned);
}

std::optional<KeyframeArchive::Recognition> KeyframeArchive::Recognize(
    const ImagePyramid& left, const std::vector<Landmark>& landmarks,
    const Eigen::Isometry3d& expected_T_world_left, int attempt, std::uint32_t seed) const {
  constexpr std::size_t kMaxTried = 8;
  const std::vector<DescribedFeature> features = DescribeAll(left, landmarks);

  std::vector<const ArchivedKeyframe*> order;
  for (const ArchivedKeyframe& keyframe : keyframes_) order.push_back(&keyframe);
  const auto Apart = [&](const ArchivedKeyframe* keyframe) {
    constexpr double kMetresPerRadian = 2.0;
    const Vector6d step = StepBetween(expected_T_world_left, keyframe->T_world_left);
    return kMetresPerRadian * step.head<3>().norm() + step.tail<3>().norm();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto* a, const auto* b) { return Apart(a) < Apart(b); });
  order.erase(order.begin(),
              order.begin() + static_cast<std::ptrdiff_t>(
                                  std::min(order.size(), kMaxTried * static_cast<std::size_t>(attempt))));
  if (order.size() > kMaxTried) order.resize(kMaxTried);

  std::optional<Recognition> best;
  for (const ArchivedKeyframe* keyframe : order) {
    const auto solution =
        terrace::Recognize(features, keyframe->points, keyframe->T_world_left, camera_, seed);
    if (!solution || (best && solution->num_inliers <= best->num_inliers)) continue;
    const Eigen::Isometry3d T_keyframe_left = keyframe->T_world_left.inverse() * solution->T_world_left;
    best = Recognition{
        solution->T_world_left,
        TransportCovariance(T_keyframe_left, keyframe->covariance) + Inverse(solution->information),
        solution->num_inliers};
  }
  return best;
}

}  // namespace terrace
