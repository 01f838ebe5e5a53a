// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "odometry/rotation.h"
#include "odometry/visual_odometry_impl.h"

namespace terrace {

void VisualOdometry::Impl::WatchPair(const PoseFinder::Found& found, const PoseEstimate& pose, double dt_s) {
  constexpr double kKeep = 0.7;
  const Vector6d speed = StepBetween(last_->T_world_left, pose.T_world_left) / std::max(dt_s, 1e-3);
  squared_speed_ = kKeep * squared_speed_ + speed * speed.transpose();
  std::vector<double> disparities;
  for (const Match& match : found.matches)
    if (match.measurement.has_disparity) disparities.push_back(match.measurement.uvd.z());
  if (!disparities.empty()) {
    const auto middle = disparities.begin() + static_cast<std::ptrdiff_t>(disparities.size() / 2);
    std::nth_element(disparities.begin(), middle, disparities.end());
    typical_disparity_px_ = std::max(*middle, 1.0);
  }
  if (const auto warning = delay_.Update(window_, found.matches, pose.t_capture))
    warnings_.push_back(*warning);
  // Columns that come and go are those of a camera that is late, too.
  if (delay_.is_off()) return;
  const auto warning = columns_.Update(window_, found.matches, pose.T_world_left, pose_finder_.noise_scale());
  if (warning) warnings_.push_back(*warning);
}

Matrix6d VisualOdometry::Impl::NotYetKnown(const PoseEstimate& pose) const {
  Matrix6d unknown = Matrix6d::Zero();
  if (!delay_.was_right()) {
    constexpr double kMost_s = 0.1;  // a frame, at the slowest that robots' cameras run
    constexpr double kFaster = 1.5;  // a robot that begins to move, than what a late image shows
    const double late_s = std::min(std::hypot(delay_.delay_s(), delay_.sigma_s()), kMost_s);
    unknown += kFaster * kFaster * late_s * late_s * squared_speed_;
  }
  if (!columns_.was_right()) {
    // Of wrong depths most goes along the way, some to its sides and into turns.
    constexpr double kAside = 0.3;
    const Eigen::Vector3d off_m =
        std::hypot(columns_.offset_px(), columns_.sigma_px()) / typical_disparity_px_ *
        (pose.T_world_left.linear().transpose() * (pose.T_world_left.translation() - start_world_));
    const double aside_m = kAside * off_m.norm(), aside_rad = aside_m / camera_.Depth(typical_disparity_px_);
    unknown.topLeftCorner<3, 3>().diagonal().array() += aside_rad * aside_rad;
    unknown.bottomRightCorner<3, 3>().diagonal().array() += aside_m * aside_m;
    unknown.bottomRightCorner<3, 3>() += off_m * off_m.transpose();
  }
  return unknown;
}

std::pair<std::string, ReasonCode> VisualOdometry::Impl::PairsTrouble() const {
  if (delay_.is_off()) return {delay_.Reason(), ReasonCode::kInputTrouble};
  if (torn_.torn())
    return {
        "the images are torn: a part of them shows the moment before; look at the camera's driver and cable",
        ReasonCode::kInputTrouble};
  if (OneImageIsOld())
    return {
        "the right image is the same as before, the left one is not: the two are not of one moment, images "
        "of "
        "the right camera get lost",
        ReasonCode::kInputTrouble};
  if (columns_.is_off()) return {columns_.Reason(), ReasonCode::kBadCalibration};
  return {pair_trouble_.reason, pair_trouble_.code};
}

PoseEstimate VisualOdometry::Impl::Published(PoseEstimate pose) const {
  pose.epoch = epoch_;
  if (pose.status == TrackingStatus::kTracking) {
    pose.covariance += NotYetKnown(pose);
    if (pose.reason.empty() && PairInDoubt()) std::tie(pose.reason, pose.reason_code) = PairsTrouble();
  }
  pose.trusted = pose.status == TrackingStatus::kTracking && pose.reason.empty();
  return pose;
}

}  // namespace terrace
