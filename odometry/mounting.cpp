// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/mounting.h"

#include <algorithm>
#include <cmath>

#include "core/field_problems.h"

namespace terrace {
namespace {

constexpr double kDegree = M_PI / 180.0;

/// Body from the raw left camera as configured.
Eigen::Isometry3d ConfiguredBody(const MountingConfig& config) {
  Eigen::Matrix3d R_body_level;  // of a camera that looks level along x
  R_body_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const auto turn = [](const std::optional<double>& angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle_deg.value_or(0.0) * kDegree, axis).toRotationMatrix();
  };
  Eigen::Isometry3d T_body_rawleft = Eigen::Isometry3d::Identity();
  T_body_rawleft.linear() = turn(config.yaw_deg, Eigen::Vector3d::UnitZ()) *
                            turn(config.pitch_deg, Eigen::Vector3d::UnitY()) *
                            turn(config.roll_deg, Eigen::Vector3d::UnitX()) * R_body_level;
  if (config.position_m.size() == 3)
    T_body_rawleft.translation() = Eigen::Map<const Eigen::Vector3d>(config.position_m.data());
  return T_body_rawleft;
}

}  // namespace

std::vector<std::string> MountingConfig::Problems() const {
  FieldProblems problems;
  problems.Require(source == "auto" || source == "body" || source == "sensor", "source", source,
                   "be auto, body or sensor");
  for (const auto& [name, angle] :
       {std::pair{"roll_deg", roll_deg}, std::pair{"pitch_deg", pitch_deg}, std::pair{"yaw_deg", yaw_deg}}) {
    if (angle) problems.RequireWithin(name, *angle, -180.0, 180.0);
  }
  problems.Require(position_m.empty() || position_m.size() == 3, "position_m", position_m, "hold x, y and z");
  problems.Require(
      std::all_of(position_m.begin(), position_m.end(), [](double p) { return std::abs(p) <= 10.0; }),
      "position_m", position_m, "lie within 10 m of the body");
  problems.Require(!(given() && source == "sensor"), "source", source,
                   "be auto or body where angles or a position are given");
  return problems.Take();
}

Mounting MountingOf(const MountingConfig& config, const StereoCalibration& calibration,
                    const Eigen::Matrix3d& R_rect_raw) {
  Mounting mounting;
  mounting.imu_noise = calibration.imu_noise;
  mounting.image_up_left = -R_rect_raw.col(1);
  if (config.source == "body" || config.given()) mounting.source = MountingSource::kBody;
  if (config.source == "sensor") mounting.source = MountingSource::kSensor;
  Eigen::Isometry3d T_rawleft_left = Eigen::Isometry3d::Identity();
  T_rawleft_left.linear() = R_rect_raw.transpose();
  if (calibration.T_body_rawleft) {
    mounting.T_body_left = *calibration.T_body_rawleft * T_rawleft_left;
    // Where the IMU sits beside the camera stays true whatever the body is.
    if (calibration.T_body_imu)
      mounting.T_left_imu = mounting.T_body_left->inverse() * *calibration.T_body_imu;
  }
  if (config.given()) mounting.T_body_left = ConfiguredBody(config) * T_rawleft_left;
  return mounting;
}

}  // namespace terrace
