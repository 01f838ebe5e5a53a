// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "core/camera.h"

namespace terrace {

/// From where the map is looked at: what cannot be seen from there is not missed.
struct Sight {
  StereoCamera camera;  ///< width 0: not known, everything is in view
  Eigen::Isometry3d T_level_left = Eigen::Isometry3d::Identity();
  double ground_z = 0.0;  ///< of the ground that the robot stands on, level frame

  Eigen::Vector3d eye() const { return T_level_left.translation(); }
  /// True when the image shows this place, or what hides it.
  bool InView(const Eigen::Vector3d& p_level) const;
};

}  // namespace terrace
