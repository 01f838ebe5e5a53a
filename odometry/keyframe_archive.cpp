// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/keyframe_archive.h"

#include <algorithm>
#include <bit>
#include <random>

#include "odometry/covariance.h"
#include "odometry/pose_solver.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

constexpr int kReach = 11;  // px of the level described

struct Comparison {
  int u1, v1, u2, v2;
};

/// The same pairs in every program: denser near the middle.
const std::array<Comparison, 256>& Pattern() {
  static const std::array<Comparison, 256> pattern = [] {
    std::mt19937 random(42);
    const auto Offset = [&random] {
      return static_cast<int>(random() % (kReach + 1)) + static_cast<int>(random() % (kReach + 1)) - kReach;
    };
    std::array<Comparison, 256> pairs{};
    for (Comparison& pair : pairs) {
      // One after the other: the order of evaluation of arguments is the compiler's.
      pair.u1 = Offset();
      pair.v1 = Offset();
      pair.u2 = Offset();
      pair.v2 = Offset();
    }
    return pairs;
  }();
  return pattern;
}

}  // namespace

std::optional<Descriptor> Describe(const ImagePyramid& image, const Eigen::Vector2d& pixel) {
  constexpr int kLevel = 1;  // smoothed, so that single pixels do not decide
  const cv::Mat1b& level = image[kLevel];
  const int u = static_cast<int>(pixel.x()) >> kLevel;
  const int v = static_cast<int>(pixel.y()) >> kLevel;
  if (u < kReach || v < kReach || u + kReach >= level.cols || v + kReach >= level.rows) return std::nullopt;
  Descriptor descriptor{};
  for (std::size_t i = 0; i < Pattern().size(); ++i) {
    const Comparison& pair = Pattern()[i];
    const bool brighter = level(v + pair.v1, u + pair.u1) > level(v + pair.v2, u + pair.u2);
    descriptor[i / 64] |= static_cast<std::uint64_t>(brighter) << (i % 64);
  }
  return descriptor;
}

int Distance(const Descriptor& a, const Descriptor& b) {
  int distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) distance += std::popcount(a[i] ^ b[i]);
  return distance;
}

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
  constexpr int kMaxDistance = 64;
  constexpr double kMaxRatio = 0.8;  // of the best to the second best
  constexpr double kSigmaPx = 1.5;   // corners are found to a pixel or two
  constexpr int kMinInliers = 15;
  constexpr double kMinInlierShare = 0.4;

  std::vector<std::pair<const Landmark*, Descriptor>> features;
  for (const Landmark& landmark : landmarks)
    if (const auto descriptor = Describe(left, landmark.pixel_host))
      features.emplace_back(&landmark, *descriptor);

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
    std::vector<PoseConstraint> constraints;
    for (const auto& [landmark, descriptor] : features) {
      int nearest = 257, second = 257;
      const ArchivedKeyframe::Point* match = nullptr;
      for (const ArchivedKeyframe::Point& point : keyframe->points) {
        const int distance = Distance(descriptor, point.descriptor);
        if (distance < nearest) {
          second = nearest;
          nearest = distance;
          match = &point;
        } else {
          second = std::min(second, distance);
        }
      }
      if (nearest > kMaxDistance || nearest > kMaxRatio * second) continue;
      PoseConstraint c;
      c.point_world = keyframe->T_world_left * match->p_left;
      c.inverse_depth = 1.0;
      c.uvd << landmark->pixel_host, landmark->disparity_host_px;
      c.whitening /= kSigmaPx;
      constraints.push_back(c);
    }
    PosePrior vague;
    vague.T_world_left = keyframe->T_world_left;
    vague.information.diagonal().setConstant(1.0);
    const PoseSolution solution = SolvePose(constraints, vague, camera_, seed);
    if (solution.num_inliers < kMinInliers ||
        solution.num_inliers < kMinInlierShare * static_cast<double>(constraints.size()) ||
        (best && solution.num_inliers <= best->num_inliers))
      continue;
    const Eigen::Isometry3d T_keyframe_left = keyframe->T_world_left.inverse() * solution.T_world_left;
    best = Recognition{
        solution.T_world_left,
        TransportCovariance(T_keyframe_left, keyframe->covariance) + Inverse(solution.information),
        solution.num_inliers};
  }
  return best;
}

}  // namespace terrace
