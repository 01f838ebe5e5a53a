// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "core/sensor_frame.h"

namespace terrace {

/// Without what no sensor can have measured: readings that are not finite or beyond the range of any IMU.
/// @param num_dropped  is raised by the readings left out
SensorSamples Credible(const SensorSamples& samples, int* num_dropped);

/// True when a pose is finite and its rotation a rotation.
bool IsPose(const Eigen::Isometry3d& pose);

}  // namespace terrace
