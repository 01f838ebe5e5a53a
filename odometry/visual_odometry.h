// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Settings of the odometry. YAML section: `odometry`.
struct OdometryConfig {
  /// Use the IMU when the sequence has one.
  bool use_imu = true;
  /// Use body attitude and leg odometry when they arrive.
  bool use_priors = true;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// What is known about how the rectified left camera sits on the robot.
struct Mounting {
  std::optional<Eigen::Isometry3d> T_body_left;
  std::optional<Eigen::Isometry3d> T_left_imu;
  ImuNoise imu_noise;
};

/// A small correction that the map offers to the odometry; applied gradually so that the world frame never
/// jumps.
struct PoseCorrection {
  FrameId frame_id = 0;
  Eigen::Isometry3d T_world_world_corrected = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};

/// A better "up" than the odometry knows, from floors and treads.
struct GravityHint {
  FrameId frame_id = 0;
  Eigen::Vector3d down_world = -Eigen::Vector3d::UnitZ();
  double sigma_rad = 0.0;
};

/// Stereo visual odometry. Fixes the world frame with the first frame and never turns or shifts it.
class VisualOdometry {
 public:
  VisualOdometry(const OdometryConfig& config, const StereoCamera& camera, const Mounting& mounting);
  ~VisualOdometry();

  /// Pose of the frame; the samples are those since the frame before.
  PoseEstimate Track(const StereoFrame& frame, const SensorSamples& samples);
  /// Pose of a moment whose images cannot be used.
  PoseEstimate Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                      const std::string& reason);

  const Gravity& gravity() const;

  void Apply(const PoseCorrection& correction);
  void Apply(const GravityHint& hint);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
