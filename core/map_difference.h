// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/terrain_map.h"

namespace terrace {

/// What turns one map into a later one. All ids ascend, and no id is in two of the lists of its kind.
struct MapDifference {
  std::vector<std::int64_t> added;               ///< regions that were not there before
  std::vector<std::int64_t> revised;             ///< regions with another revision
  std::vector<std::int64_t> removed;             ///< regions that are gone
  std::vector<std::int64_t> seen;                ///< regions that did not change but were seen since
  std::vector<std::int64_t> changed_staircases;  ///< new, or different in more than when they were seen
  std::vector<std::int64_t> removed_staircases;
};

/// True when two staircases are the same in everything but when they were seen.
bool SameBesidesTime(const Staircase& a, const Staircase& b);

/// By looking at both maps whole. Both ascend by id.
MapDifference DifferenceBetween(const TerrainMap& before, const TerrainMap& after);

}  // namespace terrace
