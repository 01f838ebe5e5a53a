// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_model.h"

#include <cmath>

namespace terrace {

Eigen::Vector2d FlightModel::UpAt(double k) const {
  if (!spiral) return direction;
  const double angle = turn_sign * run_m / radius_m * (k - 1.0);
  const Eigen::Vector2d arm(direction.x() * std::cos(angle) - direction.y() * std::sin(angle),
                            direction.x() * std::sin(angle) + direction.y() * std::cos(angle));
  return turn_sign * LeftOf(arm);
}

Eigen::Vector2d FlightModel::EdgePoint(double k, double lateral_m) const {
  if (!spiral) return origin + direction * (run_m * (k - 1.0)) + LeftOf(direction) * lateral_m;
  const Eigen::Vector2d up = UpAt(k);
  // Up is left of the arm when the flight turns left.
  return origin - turn_sign * LeftOf(up) * lateral_m;
}

}  // namespace terrace
