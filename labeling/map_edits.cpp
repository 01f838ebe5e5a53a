// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/map_edits.h"

#include <algorithm>
#include <vector>

namespace terrace {
namespace {

using RegionPtr = std::shared_ptr<const TerrainRegion>;

/// Copies a list that ascends by id with the edits in their places: all that lies between two of them at
/// once.
/// @param edit  edit(id, old item or null, &after): appends what there is now
template <typename Item, typename Edits, typename IdOf, typename Edit>
std::vector<Item> Edited(const std::vector<Item>& before, const Edits& edits, const IdOf& id_of,
                         const Edit& edit) {
  std::vector<Item> after;
  after.reserve(before.size() + edits.size());
  auto rest = before.begin();
  for (const auto& [id, value] : edits) {
    const auto next = std::lower_bound(
        rest, before.end(), id, [&](const Item& item, std::int64_t wanted) { return id_of(item) < wanted; });
    after.insert(after.end(), rest, next);
    const bool known = next != before.end() && id_of(*next) == id;
    edit(id, known ? &*next : nullptr, value, &after);
    rest = known ? next + 1 : next;
  }
  after.insert(after.end(), rest, before.end());
  return after;
}

void EditRegions(const MapEdits& edits, const TerrainMap& before, TerrainMap* map,
                 MapDifference* difference) {
  const auto edit = [&](std::int64_t id, const RegionPtr* old, const RegionPtr& now,
                        std::vector<RegionPtr>* after) {
    if (now) after->push_back(now);
    if (!old && now) difference->added.push_back(id);
    if (old && !now) difference->removed.push_back(id);
    if (old && now && *old != now)
      ((*old)->revision != now->revision ? difference->revised : difference->seen).push_back(id);
  };
  map->regions = Edited(
      before.regions, edits.regions, [](const RegionPtr& region) { return region->id; }, edit);
}

/// @return whether any was seen again
bool EditStaircases(const MapEdits& edits, const TerrainMap& before, TerrainMap* map,
                    MapDifference* difference) {
  bool any_seen = false;
  const auto edit = [&](std::int64_t id, const Staircase* old, const std::optional<Staircase>& now,
                        std::vector<Staircase>* after) {
    if (now) after->push_back(*now);
    if (old && !now) difference->removed_staircases.push_back(id);
    if (now && !(old && SameBesidesTime(*old, *now))) difference->changed_staircases.push_back(id);
    any_seen = any_seen || (old && now && old->last_seen != now->last_seen);
  };
  map->staircases = Edited(
      before.staircases, edits.staircases, [](const Staircase& staircase) { return staircase.id; }, edit);
  return any_seen;
}

}  // namespace

MapDifference ApplyEdits(const MapEdits& edits, const TerrainMap& before, TerrainMap* map) {
  MapDifference difference;
  EditRegions(edits, before, map, &difference);
  const bool staircase_seen = EditStaircases(edits, before, map, &difference);
  const bool changed = staircase_seen || !difference.added.empty() || !difference.revised.empty() ||
                       !difference.removed.empty() || !difference.changed_staircases.empty() ||
                       !difference.removed_staircases.empty();
  map->seq = before.seq + (changed ? 1 : 0);
  return difference;
}

}  // namespace terrace
