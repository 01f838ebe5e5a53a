// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "core/camera.h"

namespace terrace {

/// The image mask of the robot's own legs: 0 where the robot sees itself. Empty when `png` is empty.
/// Throws ConfigError when the file cannot be read or has another size than the camera's images.
cv::Mat1b LoadSelfMask(const std::string& png, const StereoCalibration& calibration);

}  // namespace terrace
