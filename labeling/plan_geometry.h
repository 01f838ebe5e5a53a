// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "core/plane_rings.h"

namespace terrace {

/// A closed ring in the plan, seen from above; the first vertex is not repeated.
using PlanRing = Ring2;

/// The vector turned by a quarter to the left.
inline Eigen::Vector2d LeftOf(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// The ring with vertices left out that lie closer than `tolerance_m` to what remains (Douglas and Peucker).
/// At least three vertices remain.
PlanRing SimplifyPlan(const PlanRing& ring, double tolerance_m);

/// The point of the ring itself that is nearest to p.
Eigen::Vector2d NearestOnRing(const PlanRing& ring, const Eigen::Vector2d& p);

/// The smallest rectangle around a ring with a side along one of the ring's edges.
struct PlanRectangle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d long_axis = Eigen::Vector2d::UnitX();  ///< unit
  double length_m = 0.0;                                 ///< along long_axis
  double depth_m = 0.0;                                  ///< across it, not greater than length_m

  Eigen::Vector2d short_axis() const { return {-long_axis.y(), long_axis.x()}; }
  /// How well its sides tell a direction: 1 of a line, 0 of a square.
  double Elongation() const { return length_m > 0.0 ? 1.0 - depth_m / length_m : 0.0; }
};
PlanRectangle SmallestRectangle(const PlanRing& ring);

/// Edge of the largest square, sides along the rectangle's, that lies in the first ring and in none of the
/// others; to within one cell of a raster of 1/10 of `enough_m`. No more than `enough_m` is looked for.
double LargestSquare(const std::vector<PlanRing>& rings, const PlanRectangle& rectangle, double enough_m);

/// The interval that a ring covers along an axis.
struct Interval {
  double low = 0.0;
  double high = 0.0;

  double length() const { return high - low; }
  double middle() const { return 0.5 * (low + high); }
  /// Length of what both cover; negative: the gap between them.
  double Overlap(const Interval& other) const {
    return std::min(high, other.high) - std::max(low, other.low);
  }
  /// Both, and what lies between them.
  Interval Hull(const Interval& other) const {
    return {std::min(low, other.low), std::max(high, other.high)};
  }
};
Interval Extent(const PlanRing& ring, const Eigen::Vector2d& axis);
/// The same as most of the ring has it: the middle one of the ends on lines along the axis, spread over
/// `across`, an interval to the left of it. A tongue of the outline does not move it. Unit axis.
Interval MiddleExtent(const PlanRing& ring, const Eigen::Vector2d& axis, const Interval& across);

}  // namespace terrace
