// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace terrace {

/// Whether points that the camera sees lie on a floor as it would be if this were up: on a plane within 15
/// deg of level, below the camera, with hardly anything beneath it.
/// @param up_left  unit vector
/// @return the share of the points that lie on the best one, 0..1; 0: there is none
double FloorShare(const std::vector<Eigen::Vector3d>& points_left, const Eigen::Vector3d& up_left);

/// Whether they say that the body is upright, and not the image: a wall beside the camera is a floor of a
/// body that lies on its side, and the other way round, so that one must be seen without the other.
/// @param body_up_left, image_up_left  what either takes for up; unit vectors
bool FloorConfirmsBody(const std::vector<Eigen::Vector3d>& points_left, const Eigen::Vector3d& body_up_left,
                       const Eigen::Vector3d& image_up_left);

}  // namespace terrace
