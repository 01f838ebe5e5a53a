// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <terrace/footstep_plan_v1_t.hpp>

#include "client/example/footsteps/footstep_search.h"
#include "terrace/core/terrain_map.h"

namespace terrace {

/// The plan as others on the bus read it. A step climbs when it or the one before stands on a tread.
footstep_plan_v1_t PlanMessage(const TerrainMap& map, const std::vector<Footstep>& steps,
                               double foot_radius_m);

}  // namespace terrace
