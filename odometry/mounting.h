// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"

namespace terrace {

/// How the left camera sits on the robot, where its calibration does not know. YAML section:
/// `camera.mounting`.
struct MountingConfig {
  /// What the calibration's body is (T_BS, T_body_left, an IMU). body: the robot's own, x forward, z up,
  /// however the camera is turned on it. sensor: the axes of something mounted anyhow. auto: the robot's,
  /// unless its z axis is more than 60 deg from the camera's up and nothing finds it upright within 15 deg:
  /// neither body attitude nor leg odometry nor, where these say nothing, the floor in the first image.
  std::string source = "auto";
  /// Any of these replaces the calibration's body. How the camera is turned on the body, from looking level
  /// along x: rolled about its optical axis (clockwise seen from behind), then pitched (nose down), then
  /// yawed (to the left).
  std::optional<double> roll_deg;
  std::optional<double> pitch_deg;
  std::optional<double> yaw_deg;
  /// Where the left camera is in the body, as [x, y, z].
  std::vector<double> position_m;

  bool given() const { return roll_deg || pitch_deg || yaw_deg || !position_m.empty(); }
  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// What the body of a calibration is taken for.
enum class MountingSource { kAuto, kBody, kSensor };

/// What is known about how the rectified left camera sits on the robot.
struct Mounting {
  std::optional<Eigen::Isometry3d> T_body_left;
  std::optional<Eigen::Isometry3d> T_left_imu;
  ImuNoise imu_noise;
  MountingSource source = MountingSource::kAuto;
  /// Up in the raw image, in the axes of the rectified camera, which may be turned by a quarter.
  Eigen::Vector3d image_up_left = -Eigen::Vector3d::UnitY();
};

/// Of the rectified left camera, from what calibration and configuration say of the raw one.
/// @param R_rect_raw  p_left = R_rect_raw * p_rawleft
Mounting MountingOf(const MountingConfig& config, const StereoCalibration& calibration,
                    const Eigen::Matrix3d& R_rect_raw);

}  // namespace terrace
