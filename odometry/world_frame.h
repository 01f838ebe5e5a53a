// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "odometry/odometry_config.h"

namespace terrace {

/// How the world is laid at the first pose.
struct WorldFrame {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();  ///< of the first frame
  Gravity gravity;
  Gravity without_imu;  ///< what would be known without it
  std::string warning;  ///< why a source was refused; empty: none was
};

/// Origin and yaw of the body (of the left camera when no body is known), z up by the best source there is.
/// @param samples  those up to the first frame
WorldFrame LayWorldFrame(const OdometryConfig& config, const Mounting& mounting,
                         const SensorSamples& samples);

}  // namespace terrace
