// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/place_finder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/print.h"
#include "odometry/covariance.h"

namespace terrace {
namespace {

constexpr std::size_t kViewsAFrame = 4;
constexpr std::size_t kMinFeatures = 40;

/// Whether two say the same about the place of one camera: as exact as corners tell it.
bool IsSamePlace(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kSame_m = 0.15;
  constexpr double kSame_rad = 3.0 * M_PI / 180.0;
  const Eigen::Isometry3d T_a_b = a.inverse() * b;
  return T_a_b.translation().norm() < kSame_m && Eigen::AngleAxisd(T_a_b.linear()).angle() < kSame_rad;
}

/// Between up in the world, seen from the map, and up in the map.
double UpsApart_rad(const CameraInMap& camera, const Eigen::Isometry3d& T_world_left,
                    const Gravity& gravity_world, const Gravity& gravity_map) {
  const Eigen::Vector3d up_map =
      camera.T_map_left.linear() * T_world_left.linear().transpose() * gravity_world.up_world();
  return std::acos(std::clamp(up_map.dot(gravity_map.up_world()), -1.0, 1.0));
}

CameraInMap InMap(const PoseSolution& solution) {
  // Of views in a map that was made while the camera went on: what its surfaces lie beside them by.
  constexpr double kViewNoise_m = 0.01;
  constexpr double kViewNoise_rad = 0.2 * M_PI / 180.0;
  CameraInMap camera;
  camera.T_map_left = solution.T_world_left;
  camera.covariance = Inverse(solution.information);
  camera.covariance.diagonal().head<3>().array() += kViewNoise_rad * kViewNoise_rad;
  camera.covariance.diagonal().tail<3>().array() += kViewNoise_m * kViewNoise_m;
  camera.num_corners = solution.num_inliers;
  return camera;
}

}  // namespace

void PlaceFinder::Seek(std::vector<PlaceView> views) {
  views_ = std::move(views);
  round_.reset();
  last_.reset();
  reason_ = views_.empty() ? "" : "none of its views has been compared yet";
}

std::optional<CameraInMap> PlaceFinder::Look(const StereoFrame& frame, const PoseEstimate& pose,
                                             const Gravity& gravity_world, const Gravity& gravity_map) {
  if (views_.empty()) return std::nullopt;
  if (!round_) {
    Round round;
    round.features = DescribeFrame(frame, camera_, pose.vertical_disparity_px);
    if (round.features.size() < kMinFeatures) {
      reason_ = "the image shows too little to be compared with its views";
      return std::nullopt;
    }
    round.T_world_left = pose.T_world_left;
    ++num_rounds_;
    round_ = std::move(round);
  }
  const std::size_t end = std::min(views_.size(), round_->next_view + kViewsAFrame);
  for (; round_->next_view < end; ++round_->next_view) {
    const PlaceView& view = views_[round_->next_view];
    if (const auto solution =
            Recognize(round_->features, view.corners, view.T_world_left, camera_, num_rounds_))
      round_->found.push_back(InMap(*solution));
  }
  if (round_->next_view < views_.size()) return std::nullopt;
  const Round round = *std::exchange(round_, std::nullopt);
  std::optional<CameraInMap> here = Decide(round, gravity_world, gravity_map);
  if (!here) {
    last_.reset();
    return std::nullopt;
  }
  // Where the last one would be by now, had the camera moved in the map as it has in the world.
  const bool agrees =
      last_ &&
      IsSamePlace(last_->T_map_left * last_T_world_left_.inverse() * round.T_world_left, here->T_map_left);
  last_ = here;
  last_T_world_left_ = round.T_world_left;
  if (!agrees) {
    reason_ = "one frame has been recognised, the next one must say the same";
    return std::nullopt;
  }
  here->T_map_left = here->T_map_left * round.T_world_left.inverse() * pose.T_world_left;
  return here;
}

std::optional<CameraInMap> PlaceFinder::Decide(const Round& round, const Gravity& gravity_world,
                                               const Gravity& gravity_map) {
  if (round.found.empty()) {
    reason_ = Printed("nothing that is seen is known from its %zu views", views_.size());
    return std::nullopt;
  }
  const auto has_fewer = [](const CameraInMap& a, const CameraInMap& b) {
    return a.num_corners < b.num_corners;
  };
  const CameraInMap& best = *std::max_element(round.found.begin(), round.found.end(), has_fewer);
  int num_same = 0, num_other = 0;
  for (const CameraInMap& one : round.found)
    (IsSamePlace(one.T_map_left, best.T_map_left) ? num_same : num_other) += one.num_corners;
  // What looks alike in two places says of neither that it is the one.
  constexpr double kMaxOther = 0.25;
  if (num_other > kMaxOther * num_same) {
    reason_ = "what is seen looks like several places of it";
    return std::nullopt;
  }
  constexpr double kMaxUpsApart_rad = 3.0 * M_PI / 180.0;
  const double sigma = std::hypot(gravity_world.sigma_rad, gravity_map.sigma_rad);
  const double apart = UpsApart_rad(best, round.T_world_left, gravity_world, gravity_map);
  if (apart > kMaxUpsApart_rad + 3.0 * std::min(sigma, kMaxUpsApart_rad)) {
    reason_ = Printed("what is seen looks like a place of it, but up would be off by %.0f deg",
                      apart * 180.0 / M_PI);
    return std::nullopt;
  }
  return best;
}

}  // namespace terrace
