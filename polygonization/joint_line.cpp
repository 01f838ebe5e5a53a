// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/joint_line.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {
namespace {

/// Planes that meet at a flatter angle than this (sine; 7 deg) have no line of intersection to speak of.
constexpr double kLeastSine = 0.12;

}  // namespace

std::optional<JointLine> LineOf(const PlaneFrame& frame, const Plane& other) {
  const double offset = other.SignedDistance(frame.origin);
  const Eigen::Vector2d gradient(other.normal.dot(frame.x), other.normal.dot(frame.y));
  const double sine = gradient.norm();
  if (sine < kLeastSine) return std::nullopt;
  JointLine line;
  line.to_front = gradient / sine;
  line.along = {-line.to_front.y(), line.to_front.x()};
  line.point = -offset / sine * line.to_front;
  line.sine = sine;
  return line;
}

std::optional<std::pair<double, double>> Within(const JointLine& line, const Eigen::AlignedBox2d& box) {
  double from = -std::numeric_limits<double>::infinity(), to = -from;
  for (int axis = 0; axis < 2; ++axis) {
    const double low = box.min()[axis] - line.point[axis], high = box.max()[axis] - line.point[axis];
    const double along = line.along[axis];
    if (std::abs(along) < 1e-9) {
      if (low > 0.0 || high < 0.0) return std::nullopt;
      continue;
    }
    from = std::max(from, std::min(low / along, high / along));
    to = std::min(to, std::max(low / along, high / along));
  }
  if (from > to) return std::nullopt;
  return std::pair(from, to);
}

}  // namespace terrace
