// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/map_difference.h"
#include "core/terrain_map.h"

namespace terrace {

/// What one frame did to the map: the difference between `before` and `map`, found where it happened.
struct MapChange : MapDifference {
  TerrainMapPtr before;        ///< that the lists start from; null: not known, and they say nothing
  TerrainMapPtr map;           ///< after the frame; shared and never edited; never null
  std::int64_t map_cells = 0;  ///< occupied leaves of the octree
  std::int64_t map_bytes = 0;  ///< heap of octree, patches and regions
};

}  // namespace terrace
