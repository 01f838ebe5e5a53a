// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "polygonization/bitmap_pieces.h"
#include "polygonization/plane_rings.h"

namespace terrace {

/// One connected piece of a plane, in coordinates of that plane.
struct TracedPiece {
  Ring2 outline;             ///< counter-clockwise, simple
  std::vector<Ring2> holes;  ///< clockwise, simple, inside the outline
  double area_m2 = 0.0;      ///< outline less holes
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  double support = 0.0;  ///< share of the area that footprints cover
};

/// How footprints become shapes.
struct OutlineSettings {
  double resolution_m = 0.01;
  double max_gap_m = 0.06;     ///< narrower gaps and holes are closed
  double min_width_m = 0.025;  ///< narrower tongues are cut off
  double min_area_m2 = 0.01;   ///< smaller pieces and holes are dropped
  double simplify_m = 0.008;   ///< how far a simplified edge may leave the traced one
  int max_vertices = 2000;     ///< of one shape; ragged ones are simplified further, as far as they allow
};

/// Draws rectangles of one plane into a bitmap, and traces what they cover.
class OutlineTracer {
 public:
  /// The bitmap covers [low, high]; its pixels grow when it would hold more than a few million.
  OutlineTracer(const OutlineSettings& settings, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

  /// A rectangle, by its centre and the vectors to the middles of two edges.
  void Fill(const Eigen::Vector2d& centre, const Eigen::Vector2d& half_x, const Eigen::Vector2d& half_y);

  /// What is filled so far, in pieces that hang together, in a fixed order.
  std::vector<TracedPiece> Trace();
  /// After Trace: index of the piece at a point, -1 where there is none.
  int PieceAt(const Eigen::Vector2d& p) const;

 private:
  OutlineSettings settings_;
  Eigen::Vector2d low_;  // outer corner of pixel (0, 0)
  double pixel_m_;
  cv::Mat1b filled_;
  BitmapPieces pieces_;            // after Trace
  std::vector<int> traced_index_;  // -1: too small to be one
};

}  // namespace terrace
