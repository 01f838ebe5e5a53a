// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "client/query_types.h"
#include "client/terrain_query.h"

namespace terrace {

/// All points within a radius of a segment. World frame, m.
struct Capsule {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double radius_m = 0.0;
};

/// TerrainQuery::CapsuleClearance().
Clearance ClearanceOf(const TerrainQuery& query, const Capsule& capsule, LabelSet labels,
                      const OccupiedSpace* space);

}  // namespace terrace
