// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/cell_modeller.h"

#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "../mapping/plane_world.h"

namespace terrace {
namespace {

struct SeenFloor {
  TerrainOctree octree{MappingConfig{}};
  ChangedCells cells;

  explicit SeenFloor(double height_m) {
    PlaneWorld world;
    world.AddFloor(0, 2, -1, 1, height_m);
    std::mt19937 random(1);
    for (int i = 0; i < 4; ++i) {
      const PoseEstimate pose = LookFrom(i, -0.6, 0, 0.45 + height_m, 0, 0.5);
      const ChangedCells changed =
          octree.Insert(world.See(TestCamera(), pose.T_world_left, i, 1, 0.1, &random), TestCamera(), pose);
      if (changed.keys.size() > cells.keys.size()) cells = changed;
    }
  }
};

TEST(CellModellerTest, FitsOnePlaneToTheFloorInEachCell) {
  const SeenFloor floor(0.1);
  CellModeller modeller({});
  const PatchUpdate update = modeller.Fit(floor.octree, floor.cells);
  int num_patches = 0;
  for (const PatchUpdate::CellPatches& cell : update.cells) {
    for (const Patch& patch : cell.patches) {
      ++num_patches;
      EXPECT_GT(patch.plane_world.normal.z(), 0.95);
      const Eigen::Vector3d mean = cell.centre_world + patch.moments.Mean();
      EXPECT_NEAR(mean.z(), 0.1, 0.01);  // noise of the farthest cells
    }
  }
  EXPECT_GT(num_patches, 10);
}

TEST(CellModellerTest, FindsTheStepsOfAFlightWhosePointsAreBetterThanTheyClaim) {
  PlaneWorld world;
  world.AddFloor(-1, 1.0, -1, 1, 0);
  world.AddStairs(1.0, -1, 1, 0.17, 0.28, 3);
  TerrainOctree octree{MappingConfig{}};
  CellModeller modeller({});
  std::mt19937 random(1);
  std::map<CellKey, PatchUpdate::CellPatches> cells;  // as fitted last
  for (int i = 0; i < 8; ++i) {
    const PoseEstimate pose = LookFrom(i, 0.01 * i, 0, 0.9, 0, 0.3);
    Cloud cloud = world.See(TestCamera(), pose.T_world_left, i, 1, 0.04, &random);
    for (CloudPoint& point : cloud.points) point.sigma_depth_m *= 8.0F;
    for (const PatchUpdate::CellPatches& cell :
         modeller.Fit(octree, octree.Insert(cloud, TestCamera(), pose)).cells)
      cells[cell.key] = cell;
  }
  double inclined_m2 = 0.0, all_m2 = 0.0;
  for (const auto& [key, cell] : cells) {
    if (cell.centre_world.x() < 1.0) continue;
    for (const Patch& patch : cell.patches) {
      const double up = std::abs(patch.plane_world.normal.z());
      all_m2 += patch.area_m2;
      if (up > 0.4 && up < 0.9) inclined_m2 += patch.area_m2;
    }
  }
  EXPECT_GT(all_m2, 1.0);
  EXPECT_LT(inclined_m2, 0.15 * all_m2);
}

TEST(CellModellerTest, FitsAfterAResetAsIfItHadSeenNothing) {
  const SeenFloor first(0.1), second(0.104);
  CellModeller fresh({}), used({});
  used.Fit(first.octree, first.cells);
  used.Reset();
  const PatchUpdate expected = fresh.Fit(second.octree, second.cells);
  const PatchUpdate found = used.Fit(second.octree, second.cells);
  ASSERT_EQ(found.cells.size(), expected.cells.size());
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    ASSERT_EQ(found.cells[i].patches.size(), expected.cells[i].patches.size());
    for (std::size_t k = 0; k < found.cells[i].patches.size(); ++k)
      EXPECT_EQ(found.cells[i].patches[k].plane_world.offset_m,
                expected.cells[i].patches[k].plane_world.offset_m);
  }
}

}  // namespace
}  // namespace terrace
