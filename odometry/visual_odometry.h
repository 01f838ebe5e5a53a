// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/landmark_sightings.h"
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
  /// Cells of the grid over the image; each keyframe holds at most one new feature a cell.
  int num_cells = 260;
  /// Nearest point of which a new feature is made: focal_px * baseline_m / this.
  int max_disparity_px = 192;
  /// Keyframes that are refined together.
  int window_keyframes = 8;
  /// Keyframes kept with descriptors of their features, to find back to; older ones are thinned out.
  int archived_keyframes = 200;
  /// Steps of the refinement at each keyframe, at most.
  int optimizer_iterations = 3;
  /// A new keyframe when features have moved this far by translation, as a share of the focal length.
  double keyframe_parallax = 0.06;
  /// A new keyframe when fewer than this share of the cells still holds a feature that was found.
  double keyframe_min_coverage = 0.45;
  /// Below this many points that agree, the images do not count as tracked; with an IMU, half as many will
  /// do.
  int min_inliers = 15;
  /// Bridging longer than this without an image that counts is being lost.
  double max_bridging_s = 2.0;
  /// Vertical disparity of the pair beyond which a warning names the calibration.
  double max_vertical_disparity_px = 0.5;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// What is known about how the rectified left camera sits on the robot.
struct Mounting {
  std::optional<Eigen::Isometry3d> T_body_left;
  std::optional<Eigen::Isometry3d> T_left_imu;
  ImuNoise imu_noise;
};

/// A small correction that the map offers to the odometry; taken over bit by bit, so that no pose jumps.
struct PoseCorrection {
  FrameId frame_id = 0;
  /// The map puts a camera that is said to be at T_world_left at T_corrected_world * T_world_left.
  Eigen::Isometry3d T_corrected_world = Eigen::Isometry3d::Identity();
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
  /// What became of the landmarks in the last frame: none of a frame that is bridged.
  const FrameSightings& sightings() const;
  /// What the user should be told, a sentence each, once.
  const std::vector<std::string>& warnings() const;

  void Apply(const PoseCorrection& correction);
  void Apply(const GravityHint& hint);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
