// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/terrain_map.h"

namespace terrace {

/// Staircases of a loaded map and of what is seen, each flight once.
struct JoinedStaircases {
  /// Which flight a region belongs to now, and what its step counts.
  struct Place {
    std::int64_t staircase_id = 0;
    int add_to_step = 0;

    friend bool operator==(const Place&, const Place&) = default;
  };
  std::vector<Staircase> staircases;     ///< ascending by id, without region_ids
  std::map<std::int64_t, Place> places;  ///< by the id that the region says; of those that changed
};

/// A flight that was seen and a loaded one of which it is a part, or the other way round, are one flight; it
/// keeps the loaded one's id.
/// @param loaded_world  ascending by id
/// @param seen  with ids that no loaded one has, greater than theirs
JoinedStaircases Join(const std::vector<Staircase>& loaded_world, const std::vector<Staircase>& seen);

}  // namespace terrace
