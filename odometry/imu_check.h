// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/sensor_frame.h"

namespace terrace {

/// Tests the first readings of an IMU against what every IMU on a robot says: units, signs and clocks do not
/// change later.
class ImuCheck {
 public:
  ImuCheck() = default;
  /// @param up_imu  unit vector, as far as the mounting knows
  explicit ImuCheck(const Eigen::Vector3d& up_imu) : up_imu_(up_imu) {}

  /// Takes in the samples up to a frame.
  /// @return why the IMU cannot be believed, as soon as that is certain
  std::optional<std::string> Read(const std::vector<ImuSample>& samples, Timestamp t_capture);

 private:
  std::optional<std::string> Verdict() const;

  Eigen::Vector3d up_imu_ = Eigen::Vector3d::UnitZ();
  std::optional<Timestamp> t_first_;
  int num_samples_ = 0;
  bool decided_ = false;
  Eigen::Vector3d sum_accel_ = Eigen::Vector3d::Zero();
  double sum_accel_norm_ = 0.0;
  double sum_rate_ = 0.0;
};

}  // namespace terrace
