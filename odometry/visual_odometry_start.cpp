// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include "odometry/floor_check.h"
#include "odometry/visual_odometry_impl.h"

namespace terrace {

PoseEstimate VisualOdometry::Impl::Start(const StereoFrame& frame, const ImagePyramid& left,
                                         const ImagePyramid& right, const SensorSamples& samples,
                                         const KeyframeState& biases) {
  const WorldFrame world = LayWorld(frame, left, right, samples);
  if (!world.warning.empty() && warnings_.empty()) warnings_.push_back(world.warning);
  gravity_.Start(world.gravity, world.without_imu, DownIfLevel(world.T_world_left));
  constexpr double kUp_rad = 0.3;  // an accelerometer that is off by 3 m/s^2
  if (imu_contested_ && world.gravity.source == GravitySource::kImu) gravity_.Doubt(kUp_rad);
  if (mounting_.T_left_imu)
    imu_check_ = ImuCheck(-((world.T_world_left.linear() * mounting_.T_left_imu->linear()).transpose() *
                            world.without_imu.down_world));
  PoseEstimate pose;
  pose.frame_id = frame.frame_id;
  pose.t_capture = frame.t_capture;
  pose.status = TrackingStatus::kTracking;
  pose.T_world_left = world.T_world_left;
  start_world_ = world.T_world_left.translation();
  squared_speed_.setZero();
  window_.keyframes.back().gyro_bias = biases.gyro_bias;
  window_.keyframes.back().accel_bias = biases.accel_bias;
  StartWindow(Matrix6d::Zero());
  Read(samples, frame.t_capture);
  if (static_cast<int>(window_.landmarks.size()) < config_.min_inliers) {
    window_ = {};
    pose.status = TrackingStatus::kLost;
    pose.reason = "too few features to start from";
    pose.reason_code = ReasonCode::kFewFeatures;
    return pose;
  }
  pose.num_matches = pose.num_inliers = static_cast<int>(window_.landmarks.size());
  Remember(pose);
  return pose;
}

WorldFrame VisualOdometry::Impl::LayWorld(const StereoFrame& frame, const ImagePyramid& left,
                                          const ImagePyramid& right, const SensorSamples& samples) {
  WorldFrame world = LayWorldFrame(config_, mounting_, samples);
  AddKeyframe(frame, left, right, world.T_world_left, {});
  const bool robot_speaks = config_.use_priors && !samples.priors.empty();
  if (world.warning.empty() || robot_speaks) return world;
  std::vector<Eigen::Vector3d> points_left;
  for (const Landmark& landmark : window_.landmarks)
    points_left.push_back(landmark.ray_host / landmark.inverse_depth);
  const Eigen::Vector3d body_up_left = mounting_.T_body_left->linear().transpose() * Eigen::Vector3d::UnitZ();
  if (!FloorConfirmsBody(points_left, body_up_left, mounting_.image_up_left)) return world;
  mounting_.source = MountingSource::kBody;
  world = LayWorldFrame(config_, mounting_, samples);
  window_.keyframes.back().T_world_left = world.T_world_left;
  warnings_.push_back(
      "the camera is turned far against the body's up; the floor confirms that it sits so on the robot");
  return world;
}

Eigen::Vector3d VisualOdometry::Impl::DownIfLevel(const Eigen::Isometry3d& T_world_left) const {
  if (!mounting_.T_body_left) return -Eigen::Vector3d::UnitZ();
  return -(T_world_left.linear() * mounting_.T_body_left->linear().transpose() * Eigen::Vector3d::UnitZ());
}

PoseEstimate VisualOdometry::Impl::BeginAnew(const StereoFrame& frame, const ImagePyramid& left,
                                             const ImagePyramid& right, const SensorSamples& samples) {
  ++epoch_;
  imu_contested_ = motion_.imu_in_use() && !contested_.isZero();
  const KeyframeState biases = window_.keyframes.back();
  window_ = {};
  archive_ = KeyframeArchive(camera_, config_.archived_keyframes);
  bridging_ = {};
  witness_.Reset();
  own_covariance_.setZero();
  last_.reset();
  motion_.Restart();
  return Start(frame, left, right, samples, biases);
}

PoseEstimate VisualOdometry::Impl::BeginWithout(const Motion& predicted, const StereoFrame& frame,
                                                const ImagePyramid& left, const ImagePyramid& right,
                                                const SensorSamples& samples) {
  if (predicted.by_legs) motion_.legs().Refuse();
  return BeginAnew(frame, left, right, samples);
}

}  // namespace terrace
