// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/terrain_map.h"
#include "datasets/ground_truth.h"
#include "evaluation/planar_shape.h"

namespace terrace {

/// Which true polygons are asked for besides the ordinary ones.
struct MapEvaluationOptions {
  bool include_other = false;   ///< those labelled `other`
  bool include_detail = false;  ///< those marked `detail`
};

/// One region of the result, moved onto the truth.
struct MapRegion {
  const TerrainRegion* region;
  PlanarShape shape;
  std::string label;
};

/// The regions that were seen, in the order of the map: what is predicted is no part of any figure.
/// @param T_true_result  what moves the map onto the truth
/// Throws std::runtime_error when a region is too large to be true.
std::vector<MapRegion> MoveRegions(const TerrainMap& map, const Eigen::Isometry3d& T_true_result);

struct TrueShape {
  const TruePolygon* polygon;
  PlanarShape shape;
  bool asked;  ///< its cells count
};

/// The polygons of the truth, in its order.
std::vector<TrueShape> ShapesOf(const TrueScene& truth, const MapEvaluationOptions& options);

/// Labels that offer a foothold: walkway, ramp and tread, by name.
bool IsWalkable(const std::string& label);

}  // namespace terrace
