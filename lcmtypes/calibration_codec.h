// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <terrace/calibration_v1_t.hpp>

#include "core/camera.h"
#include "core/time.h"

namespace terrace {

/// T_body_rawleft and T_body_imu travel as CanonicalQuaternion, everything else as it is. Both cameras must
/// have the same distortion model (a broken promise otherwise).
calibration_v1_t ToMessage(const StereoCalibration& calibration, Timestamp t);
/// Structure only: ask the result for its Problems().
std::optional<StereoCalibration> FromMessage(const calibration_v1_t& message);

}  // namespace terrace
