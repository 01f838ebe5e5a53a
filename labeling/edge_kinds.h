// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"
#include "labeling/region_shape.h"

namespace terrace {

/// What lies beyond every edge of a shape's polygon: outline first, then the holes, as TerrainRegion wants
/// it. Kinds only: steps are not measured yet.
std::vector<RegionEdge> EdgeKindsOf(int i, const std::vector<RegionShapePtr>& shapes,
                                    const Eigen::Matrix3d& R_level_world);

/// How far away another shape may lie and still decide the kind of an edge.
inline constexpr double kEdgeReach = 0.10;

}  // namespace terrace
