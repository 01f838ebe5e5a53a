// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "polygonization/plane_frame.h"

namespace terrace {

/// The line where another plane meets this one, in the coordinates of this one.
struct JointLine {
  Eigen::Vector2d point;
  Eigen::Vector2d along;
  Eigen::Vector2d to_front;  // where the other surface is seen from
  double sine;

  double Across(const Eigen::Vector2d& p) const { return to_front.dot(p - point); }
};

/// Where a plane meets the one of a frame; none where they are all but parallel.
std::optional<JointLine> LineOf(const PlaneFrame& frame, const Plane& other);

/// The stretch of a line that passes through a box, along the line from its point; none where it passes by.
std::optional<std::pair<double, double>> Within(const JointLine& line, const Eigen::AlignedBox2d& box);

}  // namespace terrace
