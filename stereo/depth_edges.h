// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Settings of the work at depth edges.
struct DepthEdgeSettings {
  int rounds = 2;
  int reach_px = 3;          ///< how far a pixel looks for other disparities
  float min_jump_px = 1.5f;  ///< smaller differences are slopes
  float max_fill_difference =
      10.0f;  ///< mean grey level difference that lets an unknown pixel take a neighbour's
};

/// Puts depth edges where the images have them: a pixel near one, or an unknown one, takes that of its
/// neighbours' disparities at which a small window of the two images agrees best. What the nearer surface
/// hides in the right image takes nothing. Then, of two pixels that claim the same place of the right image,
/// the one that agrees worse becomes unknown.
void SharpenDepthEdges(const cv::Mat1b& left, const cv::Mat1b& right, const DepthEdgeSettings& settings,
                       cv::Mat1f& disparity);

}  // namespace terrace
