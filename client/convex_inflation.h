// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include <Eigen/Core>

#include "client/flat_polygon.h"

namespace terrace {

/// How a convex ring is to grow.
struct Inflation {
  bool keep_seed = false;  ///< the ring has the seed inside, instead of following what it finds
  std::function<double(const FlatRing&)> worth;  ///< what is to be made large; none: the area
};

/// A large convex counter-clockwise ring within `free`, grown about `seed`: edges of `free` push it away, the
/// nearest first, by the measure of an ellipse that follows what was found (after R. Deits and R. Tedrake,
/// "Computing large convex regions of obstacle-free space through semidefinite programming", 2014; with the
/// moments of the area in place of the largest ellipse). Large, not the largest.
/// @return empty when the seed is not inside
FlatRing Inflate(const FlatPolygon& free, const Eigen::Vector2d& seed, const Inflation& how = {});

}  // namespace terrace
