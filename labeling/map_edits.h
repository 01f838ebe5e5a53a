// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "core/map_difference.h"
#include "core/terrain_map.h"

namespace terrace {

/// What is told anew of a map's regions and staircases by their ids; null and none: they are gone. What is
/// told may be what was told before.
struct MapEdits {
  std::map<std::int64_t, std::shared_ptr<const TerrainRegion>> regions;
  std::map<std::int64_t, std::optional<Staircase>> staircases;
};

/// Gives `map` the regions and staircases of `before` with the edits, and a `seq` that counts on when any of
/// them changed.
/// @return what the edits changed
MapDifference ApplyEdits(const MapEdits& edits, const TerrainMap& before, TerrainMap* map);

}  // namespace terrace
