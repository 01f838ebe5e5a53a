// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace terrace {

/// A feature of the left image in the right one, with the slant of the surface it lies on.
struct StereoAlignment {
  float disparity_px = 0.0f;
  float gradient_u = 0.0f;   ///< change of disparity per pixel to the right in the left image
  float gradient_v = 0.0f;   ///< and per pixel down
  float vertical_px = 0.0f;  ///< v in the right image less v in the left one
  float agreement = 0.0f;
  float disparity_sigma_px = 1.0f;
  float gradient_sigma = 1.0f;
};

/// Finds disparity and slant together, from a disparity that is right to about two pixels.
/// @param vertical_px  how much lower the right image is known to be
bool AlignStereo(const cv::Mat1b& left, const cv::Mat1b& right, const Eigen::Vector2f& position_left,
                 float vertical_px, StereoAlignment& result);

}  // namespace terrace
