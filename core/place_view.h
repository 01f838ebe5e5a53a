// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/time.h"

namespace terrace {

/// What a corner looks like, in 256 comparisons of grey values around it (Calonder et al., BRIEF, 2010).
using Descriptor = std::array<std::uint64_t, 4>;

/// A corner of the surroundings as one camera saw it.
struct PlaceCorner {
  Eigen::Vector3d p_left = Eigen::Vector3d::Zero();  ///< m, from the left camera
  Descriptor descriptor{};
};

/// A look at the surroundings that is kept with a map, so that the place can be recognised later.
struct PlaceView {
  Timestamp t_capture;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();  ///< in the world of the map
  std::vector<PlaceCorner> corners;
};

}  // namespace terrace
