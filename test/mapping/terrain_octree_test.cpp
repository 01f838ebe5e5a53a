// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/terrain_octree.h"

#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "plane_world.h"

namespace terrace {
namespace {

constexpr double kSigma_px = 0.1;

ChangedCells InsertView(const PlaneWorld& world, const PoseEstimate& pose, TerrainOctree* octree,
                        std::mt19937* random) {
  return octree->Insert(world.See(TestCamera(), pose.T_world_left, pose.frame_id, 2, kSigma_px, random),
                        pose);
}

std::vector<Surfel> SurfelsOf(const TerrainOctree& octree, const CellKey& key) {
  std::vector<Surfel> surfels;
  octree.CollectSurfels(key, &surfels);
  return surfels;
}

CellKey CellAt(const TerrainOctree& octree, const Eigen::Vector3d& p) {
  const Eigen::Vector3d at = (p / octree.cell_size_m()).array().floor();
  return {static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z())};
}

TEST(TerrainOctreeTest, PutsTheSurfaceOfALevelFloorWithinAMillimetre) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0.1);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  for (int i = 0; i < 10; ++i) InsertView(world, LookFrom(i, 0.02 * i, 0, 0.55, 0, 0.5), &octree, &random);
  const CellKey key = CellAt(octree, {0.9, 0.05, 0.1});
  double weight = 0, height = 0;
  for (const Surfel& s : SurfelsOf(octree, key)) {
    EXPECT_LT(s.view.z(), 0.0F);
    weight += s.num_points;
    height += s.num_points * (octree.CellCentre(key).z() + s.mean.z());
  }
  ASSERT_GT(weight, 100);
  EXPECT_NEAR(height / weight, 0.1, 1e-3);
}

TEST(TerrainOctreeTest, ReportsEachChangedCellOnceInAscendingOrder) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  const ChangedCells changed = InsertView(world, LookFrom(7, 0, 0, 0.45, 0, 0.5), &octree, &random);
  EXPECT_EQ(changed.frame_id, 7);
  ASSERT_GT(changed.keys.size(), 10U);
  for (std::size_t i = 1; i < changed.keys.size(); ++i) EXPECT_LT(changed.keys[i - 1], changed.keys[i]);
}

TEST(TerrainOctreeTest, ReportsFewCellsWhenTheSameViewComesAgainAndAgain) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  std::size_t first = 0, late = 0;
  for (int i = 0; i < 30; ++i) {
    const ChangedCells changed = InsertView(world, LookFrom(i, 0, 0, 0.45, 0, 0.5), &octree, &random);
    if (i == 0) first = changed.keys.size();
    if (i >= 20) late += changed.keys.size();
  }
  EXPECT_LT(static_cast<double>(late) / 10.0, 0.6 * static_cast<double>(first));
}

TEST(TerrainOctreeTest, ClearsTheBoxThatHasLeftAndShowsItWhenItComesBack) {
  PlaneWorld empty;
  empty.AddFloor(-1, 4, -2, 2, 0);
  PlaneWorld with_box = empty;
  with_box.AddBox(1.0, 1.3, -0.15, 0.15, 0, 0.25);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  const Eigen::Vector3d top(1.15, 0.0, 0.25);
  for (int i = 0; i < 10; ++i) InsertView(with_box, LookFrom(i, 0, 0, 0.45, 0, 0.5), &octree, &random);
  const auto num_raised = [&] {
    int num = 0;
    const CellKey key = CellAt(octree, top);
    for (const Surfel& s : SurfelsOf(octree, key))
      if (octree.CellCentre(key).z() + s.mean.z() > 0.1) ++num;
    return num;
  };
  ASSERT_GT(num_raised(), 20);
  for (int i = 10; i < 30; ++i) InsertView(empty, LookFrom(i, 0, 0, 0.45, 0, 0.5), &octree, &random);
  EXPECT_EQ(num_raised(), 0);
  for (int i = 30; i < 40; ++i) InsertView(with_box, LookFrom(i, 0, 0, 0.45, 0, 0.5), &octree, &random);
  EXPECT_GT(num_raised(), 20);
}

TEST(TerrainOctreeTest, ClearsTheFaceThatHasLeftInFrontOfAWallTooFarToBeMapped) {
  PlaneWorld with_face;
  with_face.AddFaceTowardsMinusX(1.5, -0.3, 0.3, 0.3, 0.8);
  PlaneWorld wall;
  wall.AddFaceTowardsMinusX(7.0, -6, 6, -5, 6);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  for (int i = 0; i < 10; ++i) InsertView(with_face, LookFrom(i, 0, 0, 0.45, 0, 0), &octree, &random);
  const CellKey key = CellAt(octree, {1.51, 0.1, 0.55});
  ASSERT_GT(SurfelsOf(octree, key).size(), 20U);
  for (int i = 10; i < 30; ++i) {
    const PoseEstimate pose = LookFrom(i, 0, 0, 0.45, 0, 0);
    Cloud cloud = wall.See(TestCamera(), pose.T_world_left, i, 4, 0.02, &random);
    for (CloudPoint& point : cloud.points) point.sigma_depth_m = 0.3F;
    cloud.uncertain = std::move(cloud.points);
    cloud.points.clear();
    ASSERT_GT(cloud.uncertain.size(), 1000U);
    octree.Insert(cloud, pose);
  }
  EXPECT_TRUE(SurfelsOf(octree, key).empty());
}

TEST(TerrainOctreeTest, ReplacesCoarseLeavesSeenFromAfarByFineOnesSeenNear) {
  PlaneWorld world;
  world.AddFaceTowardsMinusX(3.0, -1, 1, 0, 1);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  for (int i = 0; i < 3; ++i) InsertView(world, LookFrom(i, 0.3, 0, 0.5, 0, 0), &octree, &random);
  const CellKey key = CellAt(octree, {3.001, 0.1, 0.5});
  float largest = 0;
  for (const Surfel& s : SurfelsOf(octree, key)) largest = std::max(largest, s.size_m);
  EXPECT_GT(largest, 0.039F);
  for (int i = 3; i < 8; ++i) InsertView(world, LookFrom(i, 2.4, 0, 0.5, 0, 0), &octree, &random);
  int num_at_the_wall = 0;
  for (const Surfel& s : SurfelsOf(octree, key)) {
    // Noise seen from afar stays behind the wall, where nobody looks.
    if (std::abs(octree.CellCentre(key).x() + s.mean.x() - 3.0) > 0.02) continue;
    EXPECT_LT(s.size_m, 0.021F);
    ++num_at_the_wall;
  }
  EXPECT_GT(num_at_the_wall, 50);
}

TEST(TerrainOctreeTest, LearnsNothingFromFramesWithoutATrustedPose) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  TerrainOctree octree({}, TestCamera());
  std::mt19937 random(1);
  for (const TrackingStatus status : {TrackingStatus::kLost, TrackingStatus::kBridging}) {
    PoseEstimate pose = LookFrom(0, 0, 0, 0.45, 0, 0.5);
    pose.status = status;
    EXPECT_TRUE(InsertView(world, pose, &octree, &random).keys.empty());
  }
  EXPECT_EQ(octree.num_occupied_leaves(), 0);
}

TEST(TerrainOctreeTest, DropsPointsThatAreNoNumbersOrBeyondTheWorld) {
  Cloud cloud;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  cloud.points.push_back({{nan, 0, 1}, 100, 100, 0.01F, 0.001F});
  cloud.points.push_back({{0, 0, nan}, 100, 100, 0.01F, 0.001F});
  cloud.points.push_back({{0, 0, 1e30F}, 100, 100, 0.01F, 0.001F});
  cloud.points.push_back({{0, 0, 1}, 100, 100, nan, 0.001F});
  cloud.points.push_back({{0, 0, -1}, 100, 100, 0.01F, 0.001F});
  cloud.points.push_back({{0, 0, 1}, 320, 100, 0.01F, 0.001F});
  cloud.points.push_back({{0, 0, 1}, 100, 240, 0.01F, 0.001F});
  cloud.uncertain = cloud.points;
  PoseEstimate pose = LookFrom(0, 0, 0, 0, 0, 0);
  TerrainOctree octree({}, TestCamera());
  EXPECT_TRUE(octree.Insert(cloud, pose).keys.empty());
  EXPECT_EQ(octree.num_occupied_leaves(), 0);
}

TEST(TerrainOctreeTest, GivesTheSameBitsTwice) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  world.AddBox(1.0, 1.3, -0.15, 0.15, 0, 0.25);
  std::vector<std::vector<float>> runs;
  for (int run = 0; run < 2; ++run) {
    TerrainOctree octree({}, TestCamera());
    std::mt19937 random(1);
    std::vector<float> all;
    for (int i = 0; i < 5; ++i) {
      for (const CellKey& key :
           InsertView(world, LookFrom(i, 0.05 * i, 0, 0.45, 0, 0.5), &octree, &random).keys)
        for (const Surfel& s : SurfelsOf(octree, key))
          all.insert(all.end(), {s.mean.x(), s.mean.y(), s.mean.z(), s.covariance(0, 0), s.sigma_view_m});
    }
    runs.push_back(std::move(all));
  }
  ASSERT_EQ(runs[0].size(), runs[1].size());
  EXPECT_EQ(std::memcmp(runs[0].data(), runs[1].data(), runs[0].size() * sizeof(float)), 0);
}

TEST(MappingConfigTest, NamesEverySettingThatMakesNoSense) {
  EXPECT_TRUE(MappingConfig{}.Problems().empty());
  MappingConfig config;
  config.leaf_size_m = 0.0;
  config.leaves_per_cell = 10;
  EXPECT_EQ(config.Problems().size(), 2U);
}

}  // namespace
}  // namespace terrace
