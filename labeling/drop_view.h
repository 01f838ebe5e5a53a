// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"
#include "labeling/region_shape.h"

namespace terrace {

/// What is seen over an edge of the ground, where the ground would go on: when the line of sight through a
/// place just beyond the edge ends lower, there is no ground at that place. How low it is there is known
/// where the line ends on level ground, which is taken to reach as far as below the edge.
/// @param edge     a point of the edge, level frame
/// @param outward  unit vector in the plan, away from the ground
/// @param self     the ground
/// @param lower    what may lie lower
/// @return an edge of kind drop; none when nothing is seen there
std::optional<RegionEdge> DropSeenOver(const Eigen::Vector3d& edge, const Eigen::Vector2d& outward,
                                       const Eigen::Vector3d& eye, const RegionShape& self,
                                       const std::vector<const RegionShape*>& lower);

/// Standard deviation of the height of a support's plane at a place of the plan.
double HeightSigma(const RegionShape& support, const Eigen::Vector2d& p);

/// From farther away an edge is hardly told from where matching ends.
inline constexpr double kFarthestDrop = 5.0;
/// What is less far below the ground is no drop.
inline constexpr double kMinDrop = 0.05;

}  // namespace terrace
