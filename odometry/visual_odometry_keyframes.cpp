// SPDX-License-Identifier: BSD-3-Clause
#include <optional>
#include <utility>

#include "odometry/visual_odometry_impl.h"

namespace terrace {

void VisualOdometry::Impl::AddKeyframe(const StereoFrame& frame, const ImagePyramid& left,
                                       const ImagePyramid& right, const Eigen::Isometry3d& T_world_left,
                                       const PoseFinder::Found& found) {
  Keyframe keyframe;
  keyframe.frame_id = frame.frame_id;
  keyframe.t_capture = frame.t_capture;
  keyframe.T_world_left = T_world_left;
  if (!window_.keyframes.empty()) motion_.FillKeyframe(window_.keyframes.back(), keyframe);
  motion_.RestartKeyframe();
  const KeyframeMaker::Made made = keyframe_maker_.Make(std::move(keyframe), left, right,
                                                        vertical_.vertical_px(), found, window_, sightings_);
  keyframe_policy_.NoteMade(made.rests, made.covered_cells);
}

void VisualOdometry::Impl::StartWindow(const Matrix6d& pose_covariance, const std::optional<ImuSigmas>& imu) {
  // Biases far beyond what sensors have.
  constexpr ImuSigmas kContested{1.0, 0.1, 3.0};
  optimizer_ = WindowOptimizer(camera_, motion_.imu_in_use() ? mounting_.T_left_imu : std::nullopt);
  optimizer_.Start(window_.keyframes.front(), pose_covariance / kCorrelation, gravity().sigma_rad,
                   imu.value_or(imu_contested_ ? kContested : ImuSigmas::AtFirst()));
  keyframe_covariance_ = pose_covariance;
}

void VisualOdometry::Impl::RefineWindow(PoseEstimate* pose) {
  Eigen::Vector3d down_world = gravity().down_world;
  optimizer_.Optimize(window_, down_world, pose_finder_.noise_scale(), config_.optimizer_iterations);
  if (static_cast<int>(window_.keyframes.size()) > config_.window_keyframes) {
    archive_.Add(window_.keyframes.front(), window_.landmarks, keyframe_covariance_);
    optimizer_.DropOldest(window_, down_world, pose_finder_.noise_scale());
  }
  keyframe_covariance_ = kCorrelation * optimizer_.newest_covariance();
  const Keyframe& newest = window_.keyframes.back();
  pose->T_world_left = newest.T_world_left;
  pose->T_prev_left = last_->T_world_left.inverse() * pose->T_world_left;
  pose->covariance = keyframe_covariance_;
  if (!motion_.imu_in_use()) return;
  motion_.Refine(newest);
  gravity_.Refine(down_world, optimizer_.gravity_sigma_rad());
}

}  // namespace terrace
