// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/rounding.h"
#include "polygonization/evidence_grid.h"

namespace terrace {

/// A part of a plane in pixels: which belong to a surface, and which must not, whatever lies around them.
struct PlaneBitmap {
  double pixel_m = 0.01;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< outer corner of pixel (0, 0) [m]
  cv::Mat1b on;                                   ///< 0 or 255
  cv::Mat1b barred;                               ///< 0 or 255; never where `on` is

  Eigen::Vector2d CentreOf(int x, int y) const { return low + pixel_m * Eigen::Vector2d(x + 0.5, y + 0.5); }
  cv::Point PixelAt(const Eigen::Vector2d& p) const {
    return {FloorToInt((p.x() - low.x()) / pixel_m), FloorToInt((p.y() - low.y()) / pixel_m)};
  }
  bool Holds(const cv::Point& pixel) const {
    return pixel.x >= 0 && pixel.y >= 0 && pixel.x < on.cols && pixel.y < on.rows;
  }
  bool OnAt(const Eigen::Vector2d& p) const {
    const cv::Point pixel = PixelAt(p);
    return Holds(pixel) && on(pixel) != 0;
  }
};

/// What the evidence says of each cell, with a margin of `margin_px` around what is on the surface. Pixels
/// are cells; they grow when the bitmap would hold more than a few million.
PlaneBitmap BitmapOf(const EvidenceGrid& grid, int margin_px);

}  // namespace terrace
