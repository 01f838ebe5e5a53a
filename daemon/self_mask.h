// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// The image mask of the robot's own legs: 0 where the robot sees itself. Empty when `png` is empty.
/// Throws ConfigError when the file cannot be read or has another size than the rectified images.
/// @param size  width and height of the rectified images
cv::Mat1b LoadSelfMask(const std::string& png, std::pair<int, int> size);

}  // namespace terrace
