// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "client/flat_polygon.h"

namespace terrace {

/// Few large convex counter-clockwise rings within `free` that overlap and together cover nearly all of it;
/// each of at least `min_area_m2` and of at most 12 vertices. What is too small or too thin for such a ring
/// stays uncovered.
std::vector<FlatRing> ConvexCover(const FlatPolygon& free, double min_area_m2);

}  // namespace terrace
