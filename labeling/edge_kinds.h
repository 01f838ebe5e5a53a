// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"
#include "labeling/label_rules.h"
#include "labeling/region_shape.h"

namespace terrace {

/// What lies beyond every edge of a shape's polygon: outline first, then the holes, as TerrainRegion wants
/// it. Of the ground the height of what lies there, where it is known, in whole millimetres.
/// @param tops  whether the tops of faces were seen, one for each shape
/// @param eye   where the camera is, level frame: what is seen over an edge shows a drop
std::vector<RegionEdge> EdgesOf(int i, const std::vector<RegionShapePtr>& shapes,
                                const std::vector<TopView>& tops, const Eigen::Matrix3d& R_level_world,
                                const Eigen::Vector3d& eye);

/// Edges beyond which nothing is known now keep the drop that an edge of the region had here before.
/// @param before  as it was last told
/// @param now     its polygon, to which the edges belong
void KeepKnownDrops(const TerrainRegion& before, const Polygon& now, std::vector<RegionEdge>& edges);

/// How far away another shape may lie and still decide the kind of an edge.
inline constexpr double kEdgeReach = 0.10;

}  // namespace terrace
