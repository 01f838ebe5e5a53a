// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "stereo/steep_surfaces.h"

namespace terrace {

/// Makes connected pieces of fewer than `min_pixels` pixels unknown; neighbours (of four) are connected when
/// their disparities differ by at most `max_difference`, and by the slope more where the surface is steep.
void RemoveSpeckles(int min_pixels, float max_difference, cv::Mat1f& disparity,
                    const Steepness& steepness = {});

}  // namespace terrace
