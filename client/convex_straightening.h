// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "client/flat_polygon.h"

namespace terrace {

/// A convex ring within `free`, at least as large: each of its sides in turn is laid anew against what it
/// keeps out, in the direction that leaves most.
/// @param ring  convex, counter-clockwise, within `free`
/// @param keep_inside  a point inside that must stay inside
FlatRing Straightened(const FlatPolygon& free, FlatRing ring, const Eigen::Vector2d& keep_inside);

}  // namespace terrace
