// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/plane_rings.h"
#include "polygonization/bitmap_pieces.h"
#include "polygonization/plane_bitmap.h"
#include "polygonization/ring_simplifier.h"

namespace terrace {

/// One connected piece of a plane, in coordinates of that plane.
struct TracedPiece {
  Ring2 outline;             ///< counter-clockwise, simple
  std::vector<Ring2> holes;  ///< clockwise, simple, inside the outline
  double area_m2 = 0.0;      ///< outline less holes
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  double support = 0.0;         ///< share of the area that was seen
  std::vector<bool> seen_past;  ///< see Polygon; empty until asked for
};

/// How pixels of a plane become pieces.
struct OutlineSettings {
  double max_gap_m = 0.06;     ///< narrower gaps and holes are closed
  double min_width_m = 0.025;  ///< narrower tongues are cut off
  double min_area_m2 = 0.01;   ///< smaller pieces are dropped, and holes that nothing was seen through
  double simplify_m = 0.015;   ///< how far a simplified edge may leave the traced one
  int max_vertices = 2000;     ///< of one piece; ragged ones are simplified further, as far as they allow
};

/// Traces what is on a surface.
class OutlineTracer {
 public:
  OutlineTracer(const OutlineSettings& settings, PlaneBitmap bitmap)
      : settings_(settings), bitmap_(std::move(bitmap)) {}

  /// The pieces that hang together, in a fixed order. Edges that run along one of the lines lie on it.
  std::vector<TracedPiece> Trace(const std::vector<EdgeLine>& lines = {});
  /// After Trace: index of the piece at a point, -1 where there is none.
  int PieceAt(const Eigen::Vector2d& p) const;

 private:
  /// Gaps closed and tongues cut off.
  cv::Mat1b Tidy() const;
  bool IsGap(const Ring2& hole, const std::vector<cv::Point>& corners) const;

  OutlineSettings settings_;
  PlaneBitmap bitmap_;
  BitmapPieces pieces_;            // after Trace
  std::vector<int> traced_index_;  // of each piece; -1: too small to be one
};

}  // namespace terrace
