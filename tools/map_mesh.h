// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"

namespace terrace {

/// A region as triangles, each counter-clockwise seen from where the normal points. Vertices may be shared.
struct RegionMesh {
  std::vector<Eigen::Vector3d> vertices_world;
  std::vector<std::uint32_t> triangles;  ///< three vertices each
};

/// The region cut along its plane's x axis at the height of every vertex: between two cuts its edges cross
/// nothing, and what lies between the first and the second, the third and the fourth of them is inside. Holes
/// and vertices on one line need nothing of their own.
RegionMesh MeshOf(const TerrainRegion& region);

/// Points of the region on lines this far apart, no farther apart on them, and along all its edges.
std::vector<Eigen::Vector3d> PointsOn(const TerrainRegion& region, double spacing_m);

}  // namespace terrace
