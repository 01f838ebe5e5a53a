// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Settings of the intensity-based sub-pixel step.
struct RefinementSettings {
  int iterations = 2;
  float max_step_px = 1.0f;  ///< a pixel that wants to go further in one iteration stays where it was
  float max_jump_px = 1.0f;  ///< neighbours whose disparity differs more belong to another surface
  float min_gradient =
      1.0f;  ///< root mean square over the window, grey levels per pixel, that lets a pixel move
};

/// Moves each disparity to where the 5x5 windows of the two images agree best: a Lucas-Kanade step (1981)
/// along the row. Brightness differences cancel out: the gain of the whole pair is measured, the offset of
/// each window removed. The window follows the surface, since each of its pixels is taken at its own
/// disparity, and stops at depth edges.
/// @param disparity  in: right to about a pixel, NaN where unknown; out: refined.
/// @param sigma      out: standard deviation [px] from texture and residual, NaN where unknown.
void RefineDisparity(const cv::Mat1b& left, const cv::Mat1b& right, const RefinementSettings& settings,
                     cv::Mat1f& disparity, cv::Mat1f& sigma);

}  // namespace terrace
