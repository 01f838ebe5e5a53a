// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/time.h"

namespace terrace {

/// 8-bit grey, row-major without padding; pixel (u, v) is data[v * width + u]. Empty when nothing could be
/// read.
struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> data;

  bool empty() const { return data.empty(); }
};

/// Two images taken at one moment, raw or rectified as the calibration says.
struct StereoPair {
  Timestamp t_capture;  ///< middle of the exposure
  GrayImage left;
  GrayImage right;
  /// Why the images cannot be used (file and reason); empty when they can.
  std::string problem;
};

/// One reading of an IMU, in IMU axes.
struct ImuSample {
  Timestamp t;
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d accel =
      Eigen::Vector3d::Zero();  ///< m/s^2, gravity included: (0, 0, +9.81) at rest with z up
};

enum class PriorKind {
  kAttitude = 1,     ///< orientation only, z against gravity; yaw means nothing
  kLegOdometry = 2,  ///< relative motion counts, not the pose itself
};

/// What the robot itself believes about its body.
struct BodyPrior {
  Timestamp t;
  PriorKind kind = PriorKind::kLegOdometry;
  Eigen::Isometry3d T_odom_body = Eigen::Isometry3d::Identity();  ///< its own odometry frame, z up
  Matrix6d covariance = Matrix6d::Zero();  ///< rotation [rad], translation [m]; body frame
};

/// Everything but images that arrived since the last frame, up to and including t_capture, in order of time.
struct SensorSamples {
  std::vector<ImuSample> imu;
  std::vector<BodyPrior> priors;
};

/// What enters the pipeline for one frame.
struct SensorFrame {
  FrameId frame_id = 0;
  StereoPair pair;
  SensorSamples samples;
};

}  // namespace terrace
