// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "labeling/plan_geometry.h"

namespace terrace {

/// The law that all steps of a flight obey. Riser k = 1, 2, ... stands at run * (k - 1) past the foot edge
/// and reaches from z = foot_z + rise * (k - 1) to foot_z + rise * k; tread k begins there.
struct FlightModel {
  bool spiral = false;
  /// Straight: unit vector up the stairs in the plan. Spiral: unit vector from the axis along riser 1.
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  /// Straight: any point of the foot edge's line. Spiral: the axis.
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double foot_z = 0.0;
  double rise_m = 0.0;
  double run_m = 0.0;      ///< spiral: at radius_m
  double radius_m = 0.0;   ///< spiral: at which run_m is measured; about the middle of the width
  double turn_sign = 1.0;  ///< spiral: +1 turns left going up
  Interval lateral;        ///< straight: to the left of the origin; spiral: distance from the axis

  /// Where riser k (1 = foot) stands at a lateral position, and its direction up.
  Eigen::Vector2d EdgePoint(double k, double lateral_m) const;
  Eigen::Vector2d UpAt(double k) const;
};

}  // namespace terrace
