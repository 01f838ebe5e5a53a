// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/terrain_octree.h"

#include <cstring>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "plane_world.h"

namespace terrace {
namespace {

constexpr double kSigma_px = 0.1;

ChangedCells InsertView(const PlaneWorld& world, const PoseEstimate& pose, TerrainOctree* octree,
                        std::mt19937* random) {
  return octree->Insert(world.See(TestCamera(), pose.T_world_left, pose.frame_id, 2, kSigma_px, random),
                        TestCamera(), pose);
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
  TerrainOctree octree(MappingConfig{});
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
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  const ChangedCells changed = InsertView(world, LookFrom(7, 0, 0, 0.45, 0, 0.5), &octree, &random);
  EXPECT_EQ(changed.frame_id, 7);
  ASSERT_GT(changed.keys.size(), 10U);
  for (std::size_t i = 1; i < changed.keys.size(); ++i) EXPECT_LT(changed.keys[i - 1], changed.keys[i]);
}

TEST(TerrainOctreeTest, ReportsFewCellsWhenTheSameViewComesAgainAndAgain) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  TerrainOctree octree(MappingConfig{});
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
  TerrainOctree octree(MappingConfig{});
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
  TerrainOctree octree(MappingConfig{});
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
    octree.Insert(cloud, TestCamera(), pose);
  }
  EXPECT_TRUE(SurfelsOf(octree, key).empty());
}

TEST(TerrainOctreeTest, ReplacesCoarseLeavesSeenFromAfarByFineOnesSeenNear) {
  PlaneWorld world;
  world.AddFaceTowardsMinusX(3.0, -1, 1, 0, 1);
  TerrainOctree octree(MappingConfig{});
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
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  PoseEstimate pose = LookFrom(0, 0, 0, 0.45, 0, 0.5);
  pose.trusted = false;
  EXPECT_TRUE(InsertView(world, pose, &octree, &random).keys.empty());
  EXPECT_EQ(octree.num_leaves(), 0);
  EXPECT_EQ(octree.num_occupied_leaves(), 0);
}

TEST(TerrainOctreeTest, DropsPointsThatAreNoNumbersOrBeyondTheWorld) {
  Cloud cloud;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  cloud.points.push_back({{nan, 0, 1}, 100, 100, 0.01F});
  cloud.points.push_back({{0, 0, nan}, 100, 100, 0.01F});
  cloud.points.push_back({{0, 0, 1e30F}, 100, 100, 0.01F});
  cloud.points.push_back({{0, 0, 1}, 100, 100, nan});
  cloud.points.push_back({{0, 0, -1}, 100, 100, 0.01F});
  cloud.points.push_back({{0, 0, 1}, 320, 100, 0.01F});
  cloud.points.push_back({{0, 0, 1}, 100, 240, 0.01F});
  cloud.uncertain = cloud.points;
  PoseEstimate pose = LookFrom(0, 0, 0, 0, 0, 0);
  TerrainOctree octree(MappingConfig{});
  EXPECT_TRUE(octree.Insert(cloud, TestCamera(), pose).keys.empty());
  EXPECT_EQ(octree.num_leaves(), 0);
  EXPECT_EQ(octree.num_occupied_leaves(), 0);
}

TEST(TerrainOctreeTest, SeesTheSameSurfaceManyKilometresFromTheOrigin) {
  // A whole number of cells, beyond what OctoMap's keys of 16 bits count.
  const MappingConfig config;
  const Eigen::Vector3d far = config.cell_size_m() * Eigen::Vector3d(-20000, 31250, 0);
  std::vector<int> num_surfels;
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0, 0, 0), far}) {
    PlaneWorld world;
    world.AddFloor(place.x() - 1, place.x() + 4, place.y() - 2, place.y() + 2, 0.1);
    TerrainOctree octree(config);
    std::mt19937 random(1);
    for (int i = 0; i < 5; ++i)
      InsertView(world, LookFrom(i, place.x() + 0.02 * i, place.y(), 0.55, 0, 0.5), &octree, &random);
    const CellKey key = CellAt(octree, place + Eigen::Vector3d(0.9, 0.05, 0.1));
    num_surfels.push_back(static_cast<int>(SurfelsOf(octree, key).size()));
    for (const Surfel& s : SurfelsOf(octree, key))
      EXPECT_NEAR(octree.CellCentre(key).z() + s.mean.z(), 0.1, 0.02);
  }
  EXPECT_GT(num_surfels[0], 50);
  EXPECT_NEAR(num_surfels[1], num_surfels[0], 0.1 * num_surfels[0]);
}

TEST(TerrainOctreeTest, ForgetsWhatLiesBeyondTheWindowAndGivesItsMemoryToWhatComes) {
  constexpr double kWindow_m = 4.0;
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  PlaneWorld world;
  world.AddFloor(-2, 26, -1, 1, 0);
  FrameId frame = 0;
  std::set<CellKey> known, forgotten;
  std::int64_t bytes_early = 0;
  for (double x = 0.0; x < 20.0; x += 0.2, ++frame) {
    const PoseEstimate pose = LookFrom(frame, x, 0, 0.45, 0, 0.5);
    const Cloud cloud = world.See(TestCamera(), pose.T_world_left, frame, 4, kSigma_px, &random);
    for (const CellKey& key : octree.Insert(cloud, TestCamera(), pose).keys) {
      known.insert(key);
      forgotten.erase(key);
    }
    for (const CellKey& key : octree.ForgetBeyond(pose.T_world_left.translation(), kWindow_m)) {
      EXPECT_GT((octree.CellCentre(key) - pose.T_world_left.translation()).norm(), kWindow_m);
      forgotten.insert(key);
    }
    if (bytes_early == 0 && x > 9.0) bytes_early = octree.memory_bytes();
  }
  EXPECT_LT(static_cast<double>(octree.memory_bytes()), 1.25 * static_cast<double>(bytes_early));
  constexpr double kBlock = 1.28 * 1.74;  // cells are forgotten block by block
  for (const CellKey& key : known) {
    const double distance = (octree.CellCentre(key) - Eigen::Vector3d(20.0, 0, 0.45)).norm();
    EXPECT_TRUE(forgotten.contains(key) || distance < kWindow_m + 2.0 * kBlock) << distance;
    EXPECT_TRUE(!forgotten.contains(key) || SurfelsOf(octree, key).empty());
  }
}

TEST(TerrainOctreeTest, LearnsAPlaceAnewThatItHadForgotten) {
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  FrameId frame = 0;
  for (; frame < 5; ++frame) InsertView(world, LookFrom(frame, 0, 0, 0.45, 0, 0.5), &octree, &random);
  const CellKey key = CellAt(octree, {0.9, 0.05, 0.0});
  const std::size_t num_before = SurfelsOf(octree, key).size();
  ASSERT_GT(num_before, 50U);
  for (int i = 0; i < 20; ++i) octree.ForgetBeyond({100.0, 0.0, 0.0}, 5.0);
  EXPECT_TRUE(SurfelsOf(octree, key).empty());
  EXPECT_EQ(octree.num_leaves(), 0);
  EXPECT_EQ(octree.num_occupied_leaves(), 0);
  for (; frame < 10; ++frame) InsertView(world, LookFrom(frame, 0, 0, 0.45, 0, 0.5), &octree, &random);
  EXPECT_NEAR(static_cast<double>(SurfelsOf(octree, key).size()), static_cast<double>(num_before),
              0.1 * static_cast<double>(num_before));
}

TEST(TerrainOctreeTest, DropsWhatNeverBecameASurfaceOnceItIsOutOfViewAndKeepsSurfaces) {
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  FrameId frame = 0;
  for (; frame < 5; ++frame) InsertView(world, LookFrom(frame, 0, 0, 0.45, 0, 0.5), &octree, &random);
  // Points that only one frame shows.
  PlaneWorld noise;
  noise.AddFloor(-1, 4, -2, 2, 0.12);
  InsertView(noise, LookFrom(frame, 0, 0, 0.45, 0, 0.5), &octree, &random);
  ++frame;
  const CellKey key = CellAt(octree, {0.9, 0.05, 0.0});
  const std::size_t num_surfels = SurfelsOf(octree, key).size();
  ASSERT_GT(num_surfels, 50U);
  const Eigen::AlignedBox3d everywhere(Eigen::Vector3d(-9, -9, -9), Eigen::Vector3d(9, 9, 9));
  const std::size_t num_occupied = octree.LeavesIn(everywhere).size();
  EXPECT_EQ(octree.num_occupied_leaves(), static_cast<std::int64_t>(num_occupied));
  EXPECT_GT(static_cast<double>(octree.num_leaves()), 1.5 * static_cast<double>(num_occupied));
  // The camera turns round, and nothing is there.
  for (int i = 0; i < 120; ++i, ++frame)
    InsertView({}, LookFrom(frame, 0, 0, 0.45, 3.1, 0.5), &octree, &random);
  EXPECT_EQ(octree.num_leaves(), static_cast<std::int64_t>(num_occupied));
  EXPECT_EQ(octree.num_occupied_leaves(), octree.num_leaves());
  EXPECT_EQ(octree.LeavesIn(everywhere).size(), num_occupied);
  EXPECT_EQ(SurfelsOf(octree, key).size(), num_surfels);
}

TEST(TerrainOctreeTest, GivesTheSameBitsTwice) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0);
  world.AddBox(1.0, 1.3, -0.15, 0.15, 0, 0.25);
  std::vector<std::vector<float>> runs;
  for (int run = 0; run < 2; ++run) {
    TerrainOctree octree(MappingConfig{});
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

TEST(TerrainOctreeTest, LeavesInABoxAreThoseWithASurfaceThatReachIntoIt) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0.1);
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  for (int i = 0; i < 10; ++i) {
    InsertView(world, LookFrom(i, 0.02 * i, 0, 0.55, 0, 0.5), &octree, &random);
  }
  const auto all = octree.LeavesIn({Eigen::Vector3d(-5, -5, -5), Eigen::Vector3d(5, 5, 5)});
  EXPECT_EQ(static_cast<std::int64_t>(all.size()), [&] {
    std::vector<Surfel> surfels;
    std::int64_t count = 0;
    for (int x = -16; x < 16; ++x)
      for (int y = -16; y < 16; ++y)
        for (int z = -16; z < 16; ++z) {
          octree.CollectSurfels({x, y, z}, &surfels);
          count += static_cast<std::int64_t>(surfels.size());
        }
    return count;
  }());
  ASSERT_GT(all.size(), 100u);

  // The floor is in the leaves, and a box has those of all that reach into it.
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0.805, -0.1, -1), Eigen::Vector3d(1.2, 0.1, 1));
  const auto reaches_in = [&](const OccupiedLeaf& leaf) {
    const Eigen::Vector3d low = octree.leaf_size_m() * leaf.corner.cast<double>();
    const double size_m = octree.leaf_size_m() * (1 << leaf.level);
    return box.intersects({low, low + Eigen::Vector3d::Constant(size_m - 1e-9)});
  };
  std::size_t num_expected = 0;
  for (const OccupiedLeaf& leaf : all) num_expected += reaches_in(leaf) ? 1 : 0;
  const auto some = octree.LeavesIn(box);
  EXPECT_EQ(some.size(), num_expected);
  ASSERT_GT(some.size(), 10u);
  for (const OccupiedLeaf& leaf : some) {
    EXPECT_TRUE(reaches_in(leaf));
    EXPECT_NEAR((leaf.corner.z() + 0.5 * (1 << leaf.level)) * octree.leaf_size_m(), 0.1, 0.05);
  }
}

}  // namespace
}  // namespace terrace
