// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/terrain_map.h"

namespace terrace {

/// What one frame did to the map. All ids ascend, and no id is in two of the lists.
struct MapChange {
  TerrainMapPtr map;                  ///< after the frame; shared and never edited; never null
  std::vector<std::int64_t> added;    ///< regions that were not there before
  std::vector<std::int64_t> revised;  ///< regions with a new revision
  std::vector<std::int64_t> removed;  ///< regions that are gone
  std::vector<std::int64_t> seen;     ///< regions that the frame shows and that did not change
  std::int64_t map_cells = 0;         ///< occupied leaves of the octree
  std::int64_t map_bytes = 0;         ///< heap of octree, patches and regions
};

}  // namespace terrace
