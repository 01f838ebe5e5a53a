// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "stereo/steep_surfaces.h"

namespace terrace {

/// Mean of each 2x2 block; an odd last row or column is repeated.
void HalveImage(const cv::Mat1b& image, cv::Mat1b& half);

/// Disparities of the full image from those of the halved one, in full pixels: interpolated on surfaces, the
/// nearest pixel's at depth edges, unknown where that is. `full` has its size already.
/// @param steep  of the halved image
void DoubleDisparity(const cv::Mat1f& half, cv::Mat1f& full, const SteepSurfaces& steep = {});

}  // namespace terrace
