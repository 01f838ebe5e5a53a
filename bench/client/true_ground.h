// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "client/query_types.h"
#include "client/terrain_query.h"
#include "core/terrain_map.h"
#include "datasets/ground_truth.h"

namespace terrace {

/// The true walkable ground, as a map in the frame of the result's.
TerrainMapPtr TrueGround(const TrueScene& scene, const Eigen::Isometry3d& T_map_truth);

/// Whether true walkable ground lies under the sole less 1 cm all around, within 1 cm of its height.
bool IsRightFoothold(const TerrainQuery& truth, const Support& ground, double foot_radius_m);

}  // namespace terrace
