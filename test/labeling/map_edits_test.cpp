// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/map_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::shared_ptr<const TerrainRegion> EditedRegion(std::int64_t id, int revision) {
  auto region = std::make_shared<TerrainRegion>();
  region->id = id;
  region->revision = revision;
  return region;
}

Staircase EditedStaircase(std::int64_t id, int num_risers, Timestamp last_seen) {
  Staircase staircase;
  staircase.id = id;
  staircase.num_risers = num_risers;
  staircase.last_seen = last_seen;
  return staircase;
}

TerrainMap MapOfThree() {
  TerrainMap map;
  map.seq = 7;
  for (const std::int64_t id : {2, 4, 6}) map.regions.push_back(EditedRegion(id, 1));
  map.staircases = {EditedStaircase(1, 5, {10}), EditedStaircase(2, 3, {10})};
  return map;
}

TEST(MapEditsTest, GiveTheSameListsAsAComparisonOfTheWholeMaps) {
  const TerrainMap before = MapOfThree();
  MapEdits edits;
  edits.regions = {{1, EditedRegion(1, 1)}, {2, before.regions[0]}, {3, nullptr}, {4, nullptr},
                   {6, EditedRegion(6, 2)}, {9, EditedRegion(9, 1)}};
  edits.staircases = {{1, EditedStaircase(1, 6, {20})}, {2, std::nullopt}, {3, EditedStaircase(3, 2, {20})}};
  TerrainMap after;
  const MapDifference difference = ApplyEdits(edits, before, &after);
  const MapDifference compared = DifferenceBetween(before, after);
  EXPECT_THAT(difference.added, ElementsAre(1, 9));
  EXPECT_EQ(difference.added, compared.added);
  EXPECT_EQ(difference.revised, compared.revised);
  EXPECT_EQ(difference.removed, compared.removed);
  EXPECT_EQ(difference.changed_staircases, compared.changed_staircases);
  EXPECT_EQ(difference.removed_staircases, compared.removed_staircases);
  EXPECT_THAT(difference.revised, ElementsAre(6));
  EXPECT_THAT(difference.removed, ElementsAre(4));
  EXPECT_EQ(after.seq, 8);
}

TEST(MapEditsTest, ThatSayWhatWasSaidBeforeChangeNothing) {
  const TerrainMap before = MapOfThree();
  MapEdits edits;
  for (const auto& region : before.regions) edits.regions[region->id] = region;
  for (const Staircase& staircase : before.staircases) edits.staircases[staircase.id] = staircase;
  TerrainMap after;
  const MapDifference difference = ApplyEdits(edits, before, &after);
  EXPECT_EQ(after.regions, before.regions);
  EXPECT_THAT(difference.revised, IsEmpty());
  EXPECT_THAT(difference.changed_staircases, IsEmpty());
  EXPECT_EQ(after.seq, 7);
  // A staircase that is seen again is another state, but no other staircase.
  edits.staircases[1] = EditedStaircase(1, 5, {20});
  EXPECT_THAT(ApplyEdits(edits, before, &after).changed_staircases, IsEmpty());
  EXPECT_EQ(after.seq, 8);
}

}  // namespace
}  // namespace terrace
