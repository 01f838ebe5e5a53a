// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry.h"

namespace terrace::synthetic {

// What the makers of solids have in common.

/// "wall" or "obstacle", by the height.
std::string UprightLabel(double height_m);

/// Ground axes of something that points along yaw: x ahead, y left, z up.
Eigen::Isometry3d GroundFrame(const Eigen::Vector3d& origin, double yaw_rad);

/// Corners given in a frame, in the world.
Ring Placed(const Eigen::Isometry3d& T_world_frame, const std::vector<Eigen::Vector3d>& corners);

}  // namespace terrace::synthetic
