// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "client/flat_polygon.h"

namespace terrace {

struct DeepPoint {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  double depth_m = 0.0;  ///< distance to the nearest edge; 0: the polygon is empty
};
/// The point inside that is furthest from all edges, within `precision_m` of the greatest depth: halved
/// squares, the most promising first (after V. Agafonkin, "polylabel", 2016).
DeepPoint DeepestPoint(const FlatPolygon& polygon, double precision_m);

}  // namespace terrace
