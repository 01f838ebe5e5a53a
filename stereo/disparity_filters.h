// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Makes connected pieces of fewer than `min_pixels` pixels unknown; neighbours (of four) are connected when
/// their disparities differ by at most `max_difference`.
void RemoveSpeckles(int min_pixels, float max_difference, cv::Mat1f& disparity);

}  // namespace terrace
