// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace terrace {

double FlightFrame::Unwrapped(double along_m, double hint_m) const {
  if (period_m() <= 0.0) return along_m;
  return along_m + period_m() * std::round((hint_m - along_m) / period_m());
}

double FlightFrame::HeightNear(const RegionShape& shape, double along_m, double lateral_m) const {
  Eigen::Vector2d nearest;
  shape.PlanDistance(PointAt(along_m, lateral_m), &nearest);
  return shape.HeightAt(nearest);
}

Interval StraightFrame::AlongExtent(const RegionShape& shape, const Interval& lateral) const {
  return MiddleExtent(shape.plan.front(), direction_, lateral);
}

Interval StraightFrame::LateralExtent(const RegionShape& shape) const {
  return Extent(shape.plan.front(), LeftOf(direction_));
}

Eigen::Vector2d StraightFrame::PointAt(double along_m, double lateral_m) const {
  return direction_ * along_m + LeftOf(direction_) * lateral_m;
}

FlightModel StraightFrame::ModelAt(double foot_along_m, const Interval& lateral) const {
  FlightModel model;
  model.direction = direction_;
  model.origin = direction_ * foot_along_m + LeftOf(direction_) * lateral.middle();
  model.lateral = {-0.5 * lateral.length(), 0.5 * lateral.length()};
  return model;
}

Interval SpiralFrame::AlongExtent(const RegionShape& shape, const Interval& /*lateral*/) const {
  // Angles relative to the middle of the shape, so that none jumps by a full turn.
  const Eigen::Vector2d middle = shape.rectangle.center - axis_;
  const double middle_angle = std::atan2(middle.y(), middle.x());
  Interval turn{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Eigen::Vector2d& p : shape.plan.front()) {
    const Eigen::Vector2d arm = p - axis_;
    const double angle = std::atan2(Cross(middle, arm), middle.dot(arm));
    turn.low = std::min(turn.low, turn_sign_ * angle);
    turn.high = std::max(turn.high, turn_sign_ * angle);
  }
  const double start = turn_sign_ * middle_angle;
  return {(start + turn.low) * radius_m_, (start + turn.high) * radius_m_};
}

Interval SpiralFrame::LateralExtent(const RegionShape& shape) const {
  Interval radius{std::numeric_limits<double>::infinity(), 0.0};
  for (const Eigen::Vector2d& p : shape.plan.front()) {
    radius.low = std::min(radius.low, (p - axis_).norm());
    radius.high = std::max(radius.high, (p - axis_).norm());
  }
  return radius;
}

Eigen::Vector2d SpiralFrame::PointAt(double along_m, double lateral_m) const {
  const double angle = turn_sign_ * along_m / radius_m_;
  return axis_ + lateral_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

Eigen::Vector2d SpiralFrame::UpAt(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d arm = (p - axis_).normalized();
  return turn_sign_ * LeftOf(arm);
}

double SpiralFrame::period_m() const { return 2.0 * std::numbers::pi * radius_m_; }

FlightModel SpiralFrame::ModelAt(double foot_along_m, const Interval& lateral) const {
  FlightModel model;
  model.spiral = true;
  model.origin = axis_;
  model.radius_m = radius_m_;
  model.turn_sign = turn_sign_;
  model.lateral = lateral;
  const double angle = turn_sign_ * foot_along_m / radius_m_;
  model.direction = {std::cos(angle), std::sin(angle)};
  return model;
}

PlacedFrame FrameOf(const FlightModel& model) {
  if (model.spiral) {
    const double angle = std::atan2(model.direction.y(), model.direction.x());
    return {std::make_shared<SpiralFrame>(model.origin, model.radius_m, model.turn_sign),
            model.turn_sign * angle * model.radius_m, model.lateral};
  }
  const double shift = LeftOf(model.direction).dot(model.origin);
  return {std::make_shared<StraightFrame>(model.direction),
          model.direction.dot(model.origin),
          {model.lateral.low + shift, model.lateral.high + shift}};
}

}  // namespace terrace
