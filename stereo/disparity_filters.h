// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "stereo/repeated_patterns.h"
#include "stereo/steep_surfaces.h"

namespace terrace {

/// Where the image that the disparities belong to repeats itself, and how much smaller it was then.
struct Repetition {
  const RepeatedPatterns* patterns = nullptr;  ///< null: nowhere
  int scale = 1;
};

/// Makes connected pieces of fewer than `min_pixels` pixels unknown; neighbours (of four) are connected when
/// their disparities differ by at most `max_difference`, and by the slope more where the surface is steep.
/// Pixels whose pattern repeats itself do not count, and where they are more than half of a piece, nothing
/// says which repetition is the right one: it becomes unknown, too.
void RemoveSpeckles(int min_pixels, float max_difference, cv::Mat1f& disparity,
                    const Steepness& steepness = {}, const Repetition& repetition = {});

}  // namespace terrace
