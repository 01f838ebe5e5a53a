// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/reason_code.h"
#include "core/time.h"

namespace terrace {

enum class TrackingStatus {
  kTracking = 0,
  kBridging = 1,  ///< predicted by IMU or motion model, covariance grows
  kLost = 2,      ///< the pose means nothing
};
const char* Name(TrackingStatus status);  ///< "tracking", "bridging", "lost"

/// Where the left camera was when one stereo frame was taken.
struct PoseEstimate {
  FrameId frame_id = 0;  ///< the frame this belongs to
  Timestamp t_capture;   ///< middle of the exposure
  TrackingStatus status = TrackingStatus::kLost;
  /// Whether a map may be built on this pose: the images have shown where the camera is, and nothing speaks
  /// against it. Decided by the odometry; what else is said about the pose is for people.
  bool trusted = false;
  /// Why bridging or lost; while tracking, why the pose is in doubt. Empty when all is well.
  std::string reason;
  ReasonCode reason_code = ReasonCode::kNone;  ///< the same for programs
  /// How often the world has begun anew. Poses of different epochs have nothing to do with each other: each
  /// has its own first pose, and the covariance is against that.
  int epoch = 0;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  /// Of the error of T_world_left against the first published pose: rotation [rad], translation [m]; left
  /// frame.
  Matrix6d covariance = Matrix6d::Zero();
  /// Motion since the frame before: p_prev = T_prev_left * p_left, with its own covariance (left frame).
  Eigen::Isometry3d T_prev_left = Eigen::Isometry3d::Identity();
  Matrix6d covariance_prev = Matrix6d::Zero();
  int num_matches = 0;
  int num_inliers = 0;
  double rms_px = 0.0;                 ///< reprojection residual of the inliers
  double vertical_disparity_px = 0.0;  ///< running estimate; 0 for a well calibrated pair
};

/// Where the knowledge of "up" comes from, best first.
enum class GravitySource { kImu = 0, kAttitude = 1, kMounting = 2, kPlane = 3, kAssumed = 4 };
const char* Name(GravitySource source);  ///< "imu", "attitude", "mounting", "plane", "assumed"

/// The direction of gravity in the world frame.
struct Gravity {
  Eigen::Vector3d down_world = -Eigen::Vector3d::UnitZ();  ///< unit
  double sigma_rad = 0.0;
  GravitySource source = GravitySource::kAssumed;

  Eigen::Vector3d up_world() const { return -down_world; }
};

}  // namespace terrace
