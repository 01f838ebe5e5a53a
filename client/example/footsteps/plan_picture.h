// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "client/example/footsteps/footstep_search.h"
#include "terrace/core/terrain_map.h"

namespace terrace {

/// The ground from above, coloured by label, with the plan's feet on it (left red, right blue): the text of
/// an SVG file.
std::string PlanPicture(const TerrainMap& map, const std::vector<Footstep>& steps, double foot_radius_m);

}  // namespace terrace
