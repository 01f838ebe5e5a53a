// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/plane_rings.h"

namespace terrace {

/// A stretch of a straight line on which edges are known to lie.
struct EdgeLine {
  Eigen::Vector2d point;
  Eigen::Vector2d along;   ///< unit
  Eigen::Vector2d inside;  ///< unit; the side on which the surface lies
  double from_m = 0.0;     ///< of the stretch, along the line from the point
  double to_m = 0.0;
};

struct SimplifySettings {
  double tolerance_m = 0.015;  ///< how far an edge may leave what it replaces
  int max_vertices =
      2000;  ///< of all rings together; ragged ones are simplified further, as far as they allow
  double line_reach_m = 0.012;  ///< an edge whose ends lie this close to a line lies on it
};

/// The rings of one traced piece with fewer vertices: edges are lines fitted to what they replace, or the
/// given lines where they run along one. They neither cross nor touch; the traced ones must not either.
std::vector<Ring2> SimplifyRings(const std::vector<Ring2>& traced, const SimplifySettings& settings,
                                 const std::vector<EdgeLine>& lines = {});

}  // namespace terrace
