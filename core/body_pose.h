// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "core/reason_code.h"
#include "core/time.h"

namespace terrace {

/// Velocities in body axes, the mean since the frame before.
struct BodyVelocity {
  Eigen::Vector3d linear_body = Eigen::Vector3d::Zero();   ///< m/s
  Eigen::Vector3d angular_body = Eigen::Vector3d::Zero();  ///< rad/s
};

/// Where the robot's body was when one frame was taken, as a planner wants to know it.
struct BodyPose {
  Timestamp t_capture;
  std::int64_t map_id = 0;  ///< of the terrain in this world; 0: there is none yet
  int epoch = 0;            ///< jumps of the world so far; poses of different epochs have no common frame
  TrackingStatus status = TrackingStatus::kLost;
  ReasonCode reason_code = ReasonCode::kNone;
  std::string reason;                             ///< why bridging, lost or in doubt; empty: all is well
  std::optional<Eigen::Isometry3d> T_world_body;  ///< none when lost
  Matrix6d covariance = Matrix6d::Zero();         ///< rotation [rad], translation [m]; body axes
  std::optional<BodyVelocity> velocity;           ///< none: not known
};

}  // namespace terrace
