// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "client/flat_polygon.h"
#include "client/query_types.h"
#include "client/terrain_query.h"

namespace terrace {

/// A convex piece of a region, for planners that optimise over sets: the points T_world_plane * (v, 0) with A
/// v <= b.
struct ConvexSurface {
  std::int64_t region_id = 0;
  TerrainLabel label = TerrainLabel::kUnknown;
  Eigen::Isometry3d T_world_plane = Eigen::Isometry3d::Identity();  ///< z: the region's normal
  Eigen::MatrixX2d A;                                               ///< a row an edge, of length 1
  Eigen::VectorXd b;                                                ///< m
  FlatRing vertices;  ///< counter-clockwise, in the plane's axes [m]
  double area_m2 = 0.0;
};

/// Few, large, overlapping pieces that cover what is left of the regions within the box when everything
/// nearer than `inset_m` to an edge is taken away. Pieces smaller than `min_area_m2` are left out.
std::vector<ConvexSurface> ConvexSurfaces(const TerrainQuery& query, const Eigen::AlignedBox3d& box_world,
                                          double inset_m, double min_area_m2,
                                          LabelSet labels = kWalkableLabels);

/// A large convex piece around the ground nearest to a point, at least `inset_m` from all edges; none: there
/// is no such ground within 5 cm of the point.
/// @param max_vertices  at least 3
std::optional<ConvexSurface> LargestConvexAround(const TerrainQuery& query,
                                                 const Eigen::Vector3d& point_world, double inset_m,
                                                 std::size_t max_vertices, LabelSet labels = kWalkableLabels);

}  // namespace terrace
