// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/geometry.h"

namespace terrace {

/// Coordinates in a plane that moves a little while they stay: axes laid when it was first known, and the
/// plane as it lies now, reached along the normal that the axes belong to.
struct PlaneFrame {
  Eigen::Vector3d origin;  ///< of the coordinates, in the plane, world frame
  Eigen::Vector3d x, y;    ///< one metre along each coordinate, in the plane

  PlaneFrame(const Plane& plane_world, const Eigen::Vector3d& origin_world, const PlaneAxes& axes,
             const Eigen::Vector3d& anchor_normal)
      : axes_(axes), axes_origin_(origin_world) {
    const Eigen::Vector3d along = anchor_normal / plane_world.normal.dot(anchor_normal);
    origin = origin_world - plane_world.SignedDistance(origin_world) * along;
    x = axes.x - plane_world.normal.dot(axes.x) * along;
    y = axes.y - plane_world.normal.dot(axes.y) * along;
  }

  Eigen::Vector3d ToWorld(const Eigen::Vector2d& p) const { return origin + p.x() * x + p.y() * y; }
  Eigen::Vector2d ToPlane(const Eigen::Vector3d& p_world) const {
    return {axes_.x.dot(p_world - axes_origin_), axes_.y.dot(p_world - axes_origin_)};
  }

 private:
  PlaneAxes axes_;
  Eigen::Vector3d axes_origin_;
};

}  // namespace terrace
