// SPDX-License-Identifier: BSD-3-Clause
#include "core/map_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::shared_ptr<const TerrainRegion> Region(std::int64_t id, int revision, std::int64_t seen_ns) {
  auto region = std::make_shared<TerrainRegion>();
  region->id = id;
  region->revision = revision;
  region->last_seen.ns = seen_ns;
  return region;
}

TEST(MapDifferenceTest, FindsNothingBetweenAMapAndItself) {
  TerrainMap map;
  map.regions = {Region(1, 1, 10), Region(4, 1, 10)};
  map.staircases = {{.id = 2}};
  const MapDifference none = DifferenceBetween(map, map);
  EXPECT_THAT(none.added, IsEmpty());
  EXPECT_THAT(none.revised, IsEmpty());
  EXPECT_THAT(none.removed, IsEmpty());
  EXPECT_THAT(none.seen, IsEmpty());
  EXPECT_THAT(none.changed_staircases, IsEmpty());
  EXPECT_THAT(none.removed_staircases, IsEmpty());
}

TEST(MapDifferenceTest, PutsEveryRegionIntoTheListOfWhatHappenedToIt) {
  TerrainMap before, after;
  const auto kept = Region(3, 1, 10);
  before.regions = {Region(1, 1, 10), Region(2, 1, 10), kept, Region(5, 7, 10), Region(9, 1, 10)};
  after.regions = {Region(2, 2, 20), kept, Region(4, 1, 20), Region(5, 7, 20), Region(10, 1, 20)};
  const MapDifference difference = DifferenceBetween(before, after);
  EXPECT_THAT(difference.added, ElementsAre(4, 10));
  EXPECT_THAT(difference.revised, ElementsAre(2));
  EXPECT_THAT(difference.removed, ElementsAre(1, 9));
  EXPECT_THAT(difference.seen, ElementsAre(5));
}

TEST(MapDifferenceTest, CallsAStaircaseChangedForMoreThanBeingSeenAgain) {
  TerrainMap before, after;
  before.staircases = {{.id = 1, .riser_m = 0.17}, {.id = 2, .riser_m = 0.17}, {.id = 3}};
  after.staircases = {{.id = 1, .riser_m = 0.17}, {.id = 2, .riser_m = 0.18}, {.id = 4}};
  after.staircases[0].last_seen.ns = 99;
  const MapDifference difference = DifferenceBetween(before, after);
  EXPECT_THAT(difference.changed_staircases, ElementsAre(2, 4));
  EXPECT_THAT(difference.removed_staircases, ElementsAre(3));
}

}  // namespace
}  // namespace terrace
