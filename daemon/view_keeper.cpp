// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/view_keeper.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "odometry/place_recognition.h"

namespace terrace {
namespace {

// Fewer corners recognise nothing.
constexpr std::size_t kMinCorners = 40;
/// Frames after which a place that showed fewer is tried again: describing corners costs as much as tracking.
constexpr int kPatience = 10;

}  // namespace

bool AreNeighbours(const Eigen::Isometry3d& T_world_left_a, const Eigen::Isometry3d& T_world_left_b) {
  constexpr double kNear_m = 0.4;
  constexpr double kNear_rad = 15.0 * M_PI / 180.0;
  const Eigen::Isometry3d T_a_b = T_world_left_a.inverse() * T_world_left_b;
  return T_a_b.translation().norm() < kNear_m && Eigen::AngleAxisd(T_a_b.linear()).angle() < kNear_rad;
}

void ViewKeeper::Add(const StereoFrame& frame, const PoseEstimate& pose) {
  for (const PlaceView& view : views_)
    if (AreNeighbours(view.T_world_left, pose.T_world_left)) return;
  if (frames_to_wait_ > 0) {
    --frames_to_wait_;
    return;
  }
  PlaceView view;
  view.t_capture = pose.t_capture;
  view.T_world_left = pose.T_world_left;
  for (const DescribedFeature& feature : DescribeFrame(frame, camera_, pose.vertical_disparity_px))
    view.corners.push_back(
        {camera_.Triangulate(feature.uvd.x(), feature.uvd.y(), feature.uvd.z()), feature.descriptor});
  if (view.corners.size() < kMinCorners) {
    frames_to_wait_ = kPatience;
    return;
  }
  views_.push_back(std::move(view));
  if (views_.size() <= max_views_) return;
  // Every second one of the older half goes: the past stays covered, only less densely.
  std::vector<PlaceView> thinned;
  for (std::size_t i = 0; i < views_.size(); ++i)
    if (i % 2 == 0 || i >= views_.size() / 2) thinned.push_back(std::move(views_[i]));
  views_ = std::move(thinned);
}

}  // namespace terrace
