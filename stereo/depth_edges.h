// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <opencv2/core/mat.hpp>

#include "stereo/disparity_units.h"
#include "stereo/steep_surfaces.h"

namespace terrace {

/// Settings of the work at depth edges.
struct DepthEdgeSettings {
  int rounds = 2;
  int reach_px = 3;          ///< how far a pixel looks for other disparities
  float min_jump_px = 1.5f;  ///< smaller differences are slopes
  float max_fill_difference =
      10.0f;  ///< mean grey level difference that lets an unknown pixel take a neighbour's
};

/// Puts depth edges where the images have them.
class DepthEdgeSharpener {
 public:
  explicit DepthEdgeSharpener(const DepthEdgeSettings& settings);
  ~DepthEdgeSharpener();

  /// A pixel near an edge, or an unknown one, takes that of its neighbours' disparities at which a small
  /// window of the two images agrees best. Then, of two surfaces that claim the same place of the right
  /// image, the one that agrees worse becomes unknown, so that what the nearer one hides gets nothing. Last,
  /// unknown pixels take a neighbour's disparity where the images agree and nobody claims the place it leads
  /// to. Above and below neighbours count as they would be in the pixel's own row where the surface is steep.
  void Sharpen(const cv::Mat1b& left, const cv::Mat1b& right, UnitImage& disparity,
               const Steepness& steepness = {});

 private:
  class Scratch;
  DepthEdgeSettings settings_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace terrace
