// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Makes disparities unknown that nothing in the image speaks for: where the image is flat (sky, a white
/// wall, a dark hole) and nothing is known, matching still carries the disparity of a textured edge into the
/// flat, as far as its windows and paths reach. What is given between a flat place without a disparity and
/// texture, on a way over flat pixels no longer than that reach, is taken for such a fringe. A flat place
/// with texture all around it keeps what it has, and so does a wall that goes on flat beside what is unknown.
/// @param image       left image
/// @param half_image  the same at half its size
/// @param disparity   of the size of `image`, NaN = unknown
/// @param sigma       unknown where the disparity is
void ForgetFlatFringes(const cv::Mat1b& image, const cv::Mat1b& half_image, cv::Mat1f& disparity,
                       cv::Mat1f& sigma);

}  // namespace terrace
