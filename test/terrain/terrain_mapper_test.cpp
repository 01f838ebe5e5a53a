// SPDX-License-Identifier: BSD-3-Clause
#include "terrain/terrain_mapper.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/mapping/disparity_of_planes.h"

namespace terrace {
namespace {

constexpr float kSigma_px = 0.1F;

/// A robot that looks at a world of planes from where it is told to stand.
class Walker {
 public:
  explicit Walker(PlaneWorld world) : world_(std::move(world)) {}

  MapChange See(TerrainMapper* mapper, double x, double y = 0.0, double yaw_rad = 0.0) {
    PoseEstimate pose = LookFrom(frame_, x, y, 0.45, yaw_rad, 0.5);
    pose.t_capture = Timestamp{1'000'000'000 + 100'000'000 * frame_};
    ++frame_;
    const DisparityImage disparity = DisparityOf(world_, TestCamera(), pose, kSigma_px, &random_);
    return mapper->Update({disparity, TestCamera(), cv::Mat1b()}, pose, LevelGravity());
  }

  void Change(PlaneWorld world) { world_ = std::move(world); }

  static Gravity LevelGravity() {
    Gravity gravity;
    gravity.source = GravitySource::kImu;
    gravity.sigma_rad = 0.005;
    return gravity;
  }

 private:
  PlaneWorld world_;
  FrameId frame_ = 0;
  std::mt19937 random_{1};
};

PlaneWorld Room() {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  world.AddBox(1.2, 1.6, -0.3, 0.3, 0, 0.3);
  return world;
}

class TerrainMapperTest : public ::testing::Test {
 protected:
  StageMeters meters_;
  TerrainMapper mapper_{TerrainConfig{}, TestCamera(), std::nullopt, &meters_};
};

TEST_F(TerrainMapperTest, WhatFramesAddReviseAndRemoveIsTheWholeMap) {
  Walker walker(Room());
  std::map<std::int64_t, int> revisions;
  for (int i = 0; i < 12; ++i) {
    const MapChange change = walker.See(&mapper_, 0.03 * i);
    for (const std::int64_t id : change.removed) EXPECT_EQ(revisions.erase(id), 1U);
    std::map<std::int64_t, int> now;
    for (const auto& region : change.map->regions) now[region->id] = region->revision;
    for (const std::int64_t id : change.added) EXPECT_TRUE(revisions.emplace(id, now.at(id)).second);
    for (const std::int64_t id : change.revised)
      EXPECT_GT(now.at(id), std::exchange(revisions.at(id), now.at(id)));
    EXPECT_EQ(revisions, now);
    EXPECT_EQ(change.map, mapper_.map());
  }
  EXPECT_GE(revisions.size(), 2U);
}

TEST_F(TerrainMapperTest, ARobotThatStandsChangesNothingUntilSomethingElseChanges) {
  Walker walker(Room());
  for (int i = 0; i < 43; ++i) walker.See(&mapper_, 0.0);
  for (int i = 0; i < 30; ++i) {
    const MapChange change = walker.See(&mapper_, 0.0);
    EXPECT_TRUE(change.added.empty() && change.revised.empty() && change.removed.empty()) << i;
    EXPECT_FALSE(change.seen.empty()) << i;
  }
  PlaneWorld with_another_box = Room();
  with_another_box.AddBox(1.0, 1.2, 0.5, 0.8, 0, 0.2);
  walker.Change(with_another_box);
  int num_added = 0;
  for (int i = 0; i < 5; ++i) num_added += static_cast<int>(walker.See(&mapper_, 0.0).added.size());
  EXPECT_GT(num_added, 0);
}

TEST_F(TerrainMapperTest, ANewMapKnowsNothingOfTheOldOne) {
  Walker room(Room());
  for (int i = 0; i < 8; ++i) room.See(&mapper_, 0.0);
  ASSERT_FALSE(mapper_.map()->regions.empty());
  const std::int64_t map_id = mapper_.map()->map_id;
  mapper_.Reset();
  EXPECT_TRUE(mapper_.map()->regions.empty());
  EXPECT_EQ(mapper_.map()->map_id, map_id + 1);
  EXPECT_EQ(mapper_.Unchanged().map_cells, 0);
  EXPECT_FALSE(mapper_.gravity_hint());

  // The same frames lead to the same map as in a mapper that never saw the room.
  TerrainMapper fresh(TerrainConfig{}, TestCamera(), std::nullopt, &meters_);
  PlaneWorld tilted;
  tilted.rectangles.push_back({{-1, -2, -0.05}, {5, 0, 0.25}, {0, 4, 0}});
  Walker after_reset(tilted), from_nothing(tilted);
  for (int i = 0; i < 8; ++i) {
    const MapChange a = after_reset.See(&mapper_, 0.0);
    const MapChange b = from_nothing.See(&fresh, 0.0);
    ASSERT_EQ(a.map->regions.size(), b.map->regions.size());
    for (std::size_t k = 0; k < a.map->regions.size(); ++k) {
      EXPECT_EQ(a.map->regions[k]->plane_world.normal, b.map->regions[k]->plane_world.normal);
      EXPECT_EQ(a.map->regions[k]->outline_world, b.map->regions[k]->outline_world);
    }
  }
  EXPECT_FALSE(mapper_.map()->regions.empty());
}

/// Area of what is level within 3 m of the origin.
double LevelAreaAtTheOrigin(const TerrainMap& map) {
  double area_m2 = 0.0;
  for (const auto& region : map.regions)
    if (region->plane_world.normal.z() > 0.9 && region->centroid_world.head<2>().norm() < 3.0)
      area_m2 += region->area_m2;
  return area_m2;
}

TEST_F(TerrainMapperTest, RegionsBeyondTheWindowStayAndAreTakenUpAgainWithTheirIds) {
  PlaneWorld world = Room();
  world.AddFloor(39, 44, -2, 2, 0);
  Walker walker(world);
  for (int i = 0; i < 24; ++i) walker.See(&mapper_, 0.02 * (i % 12));
  const TerrainMapPtr before = mapper_.map();
  ASSERT_GE(before->regions.size(), 2U);

  TerrainMapper elsewhere(TerrainConfig{}, TestCamera(), std::nullopt, &meters_);
  Walker other_walker(world);
  for (int i = 0; i < 40; ++i) {
    walker.See(&mapper_, 40.0 + 0.02 * i);
    other_walker.See(&elsewhere, 40.0 + 0.02 * i);
  }
  for (const auto& region : before->regions)
    EXPECT_TRUE(std::any_of(mapper_.map()->regions.begin(), mapper_.map()->regions.end(),
                            [&](const auto& other) { return other->id == region->id; }))
        << region->id;
  const auto cells_elsewhere = static_cast<double>(elsewhere.Unchanged().map_cells);
  EXPECT_NEAR(static_cast<double>(mapper_.Unchanged().map_cells), cells_elsewhere, 0.05 * cells_elsewhere)
      << "evidence of the room is still there";

  for (int i = 0; i < 20; ++i) walker.See(&mapper_, 0.02 * (i % 12));
  for (const auto& region : before->regions)
    EXPECT_TRUE(std::any_of(mapper_.map()->regions.begin(), mapper_.map()->regions.end(),
                            [&](const auto& other) { return other->id == region->id; }))
        << region->id;
  EXPECT_NEAR(LevelAreaAtTheOrigin(*mapper_.map()), LevelAreaAtTheOrigin(*before),
              0.05 * LevelAreaAtTheOrigin(*before))
      << "no second copy";
}

TEST(TerrainMapperReachTest, RegionsBeyondWhatIsKeptAreForgottenAndToldSo) {
  StageMeters meters;
  TerrainConfig config;
  config.mapping.keep_beyond_m = 25.0;
  TerrainMapper mapper(config, TestCamera(), std::nullopt, &meters);
  PlaneWorld world = Room();
  world.AddFloor(39, 44, -2, 2, 0);
  Walker walker(world);
  for (int i = 0; i < 24; ++i) walker.See(&mapper, 0.02 * (i % 12));
  std::set<std::int64_t> here;
  for (const auto& region : mapper.map()->regions) here.insert(region->id);
  ASSERT_GE(here.size(), 2U);
  for (int i = 0; i < 40; ++i)
    for (const std::int64_t id : walker.See(&mapper, 40.0 + 0.05 * i).removed) here.erase(id);
  EXPECT_TRUE(here.empty());
  ASSERT_FALSE(mapper.map()->regions.empty());
  for (const auto& region : mapper.map()->regions) EXPECT_GT(region->centroid_world.x(), 30.0);
}

TEST_F(TerrainMapperTest, WhatLeftWhileNobodyLookedGoesWhenThePlaceIsSeenAgain) {
  Walker walker(Room());
  for (int i = 0; i < 12; ++i) walker.See(&mapper_, 0.02 * i);
  const auto has_box_top = [&] {
    return std::any_of(mapper_.map()->regions.begin(), mapper_.map()->regions.end(), [](const auto& region) {
      return region->plane_world.normal.z() > 0.9 && region->centroid_world.z() > 0.2;
    });
  };
  ASSERT_TRUE(has_box_top());
  PlaneWorld emptied;
  emptied.AddFloor(-1, 4, -2, 2, 0);
  emptied.AddFloor(39, 44, -2, 2, 0);
  walker.Change(emptied);
  for (int i = 0; i < 40; ++i) walker.See(&mapper_, 40.0 + 0.02 * i);
  EXPECT_TRUE(has_box_top());
  for (int i = 0; i < 40; ++i) walker.See(&mapper_, 0.02 * (i % 12));
  EXPECT_FALSE(has_box_top());
}

TEST_F(TerrainMapperTest, MeasuresEachStageOncePerFrame) {
  Walker walker(Room());
  for (int i = 0; i < 3; ++i) walker.See(&mapper_, 0.0);
  const std::vector<StageCost> costs = meters_.costs();
  for (const StageId stage :
       {StageId::kDecomposition, StageId::kModelling, StageId::kMerging, StageId::kLabels}) {
    EXPECT_EQ(costs[static_cast<std::size_t>(stage)].count, 3);
    EXPECT_GT(costs[static_cast<std::size_t>(stage)].cpu_ms_mean, 0.0);
  }
}

TEST_F(TerrainMapperTest, TellsTheOdometryWhereLevelGroundSaysUpIs) {
  Walker walker(Room());
  for (int i = 0; i < 8; ++i) walker.See(&mapper_, 0.0);
  ASSERT_TRUE(mapper_.gravity_hint());
  EXPECT_GT(-mapper_.gravity_hint()->down_world.z(), 0.9999);
}

}  // namespace
}  // namespace terrace
