// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// The same for two images whose looked-at rows (every eighth) show the same bits, else different. Never 0.
/// Cameras never give the same bits twice while they work, as their noise changes.
std::uint64_t ImageFingerprint(const cv::Mat1b& image);

}  // namespace terrace
