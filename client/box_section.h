// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "client/flat_polygon.h"
#include "client/region_shape.h"

namespace terrace {

/// Whether any point of the region lies in the box, its border included.
bool ReachesInto(const RegionShape& shape, const Eigen::AlignedBox3d& box_world);

/// Where the box cuts the region's plane: a convex counter-clockwise ring in the plane's axes, no further out
/// than the region; empty: nowhere.
FlatRing SectionOf(const RegionShape& shape, const Eigen::AlignedBox3d& box_world);

}  // namespace terrace
