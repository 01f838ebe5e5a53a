// SPDX-License-Identifier: BSD-3-Clause
#include "core/map_difference.h"

namespace terrace {
namespace {

/// Walks two lists that ascend by id side by side: `gone(item)` for what only the first has, `fresh(item)`
/// for what only the second has, `both(old, new)` for the rest.
template <typename Items, typename IdOf, typename Gone, typename Fresh, typename Both>
void SideBySide(const Items& before, const Items& after, IdOf id, Gone gone, Fresh fresh, Both both) {
  auto old = before.begin();
  for (const auto& item : after) {
    for (; old != before.end() && id(*old) < id(item); ++old) gone(*old);
    if (old != before.end() && id(*old) == id(item)) {
      both(*old, item);
      ++old;
    } else {
      fresh(item);
    }
  }
  for (; old != before.end(); ++old) gone(*old);
}

}  // namespace

bool SameBesidesTime(const Staircase& a, const Staircase& b) {
  return a.num_risers == b.num_risers && a.num_treads == b.num_treads && a.riser_m == b.riser_m &&
         a.riser_sigma_m == b.riser_sigma_m && a.tread_m == b.tread_m && a.tread_sigma_m == b.tread_sigma_m &&
         a.width_m == b.width_m && a.foot_edge_world == b.foot_edge_world &&
         a.head_edge_world == b.head_edge_world && a.direction_up_world == b.direction_up_world &&
         a.turn_per_step_rad == b.turn_per_step_rad && a.pitch_rad == b.pitch_rad &&
         a.confidence == b.confidence && a.region_ids == b.region_ids;
}

MapDifference DifferenceBetween(const TerrainMap& before, const TerrainMap& after) {
  using RegionPtr = std::shared_ptr<const TerrainRegion>;
  MapDifference difference;
  SideBySide(
      before.regions, after.regions, [](const RegionPtr& region) { return region->id; },
      [&](const RegionPtr& region) { difference.removed.push_back(region->id); },
      [&](const RegionPtr& region) { difference.added.push_back(region->id); },
      [&](const RegionPtr& old, const RegionPtr& region) {
        if (old == region) return;
        if (old->revision != region->revision) {
          difference.revised.push_back(region->id);
        } else if (old->last_seen < region->last_seen) {
          difference.seen.push_back(region->id);
        }
      });
  SideBySide(
      before.staircases, after.staircases, [](const Staircase& staircase) { return staircase.id; },
      [&](const Staircase& staircase) { difference.removed_staircases.push_back(staircase.id); },
      [&](const Staircase& staircase) { difference.changed_staircases.push_back(staircase.id); },
      [&](const Staircase& old, const Staircase& staircase) {
        if (!SameBesidesTime(old, staircase)) difference.changed_staircases.push_back(staircase.id);
      });
  return difference;
}

}  // namespace terrace
