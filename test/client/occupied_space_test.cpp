// SPDX-License-Identifier: BSD-3-Clause
#include "client/occupied_space.h"

#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "mapping/octomap_bytes.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

TerrainQuery FloorQuery() {
  return TerrainQuery(MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(0, 0, 2, 2))}));
}

/// Leaves of 2 cm: one in the floor, one 40 cm above it, a coarse one of 8 cm beside it.
octree_v1_t ExampleOctree() {
  octree_v1_t message{};
  message.map_id = MadeMap({})->map_id;
  message.encoding = octree_v1_t::OCTOMAP_OT;
  for (int axis = 0; axis < 3; ++axis) {
    message.box_min[axis] = -3.0;
    message.box_max[axis] = 3.0;
  }
  message.data = OctomapBytes({{{50, 50, 0}, 0, 1}, {{50, 50, 20}, 0, 1}, {{-40, 0, 4}, 2, 1}}, 0.02,
                              OctomapFormat::kOt);
  message.n_bytes = static_cast<std::int32_t>(message.data.size());
  return message;
}

TEST(OccupiedSpaceTest, KnowsWhatLiesOnARegionAndWhatOverItInItsHoleOrBesideIt) {
  const TerrainQuery query = TerrainQuery(MadeMap({MadeRegion(
      1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(-1, -1, 1, 1), {Rectangle(-0.2, -0.2, 0.2, 0.2)})}));
  EXPECT_TRUE(IsOnARegion({0.5, 0.5, 0.02}, 0.0, query));
  EXPECT_TRUE(IsOnARegion({1.02, 0.5, -0.02}, 0.0, query));
  EXPECT_FALSE(IsOnARegion({0.5, 0.5, 0.04}, 0.0, query));
  EXPECT_FALSE(IsOnARegion({0.0, 0.0, 0.0}, 0.0, query));
  EXPECT_FALSE(IsOnARegion({1.1, 0.5, 0.0}, 0.0, query));
  EXPECT_TRUE(IsOnARegion({1.1, 0.5, 0.0}, 0.08, query));
  auto rough = MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(-1, -1, 1, 1));
  rough->rms_m = 0.02;
  EXPECT_TRUE(IsOnARegion({0.5, 0.5, 0.05}, 0.0, TerrainQuery(MadeMap({rough}))));
}

TEST(OccupiedSpaceTest, KeepsTheLeavesThatLieOnNoRegion) {
  const OccupiedSpace space(ExampleOctree(), FloorQuery());
  EXPECT_EQ(space.box_world().min(), Eigen::Vector3d(-3, -3, -3));
  ASSERT_EQ(space.cubes_world().size(), 2u);
  double volume_m3 = 0.0;
  for (const Eigen::AlignedBox3d& cube : space.cubes_world()) volume_m3 += cube.volume();
  EXPECT_NEAR(volume_m3, 0.02 * 0.02 * 0.02 + 0.08 * 0.08 * 0.08, 1e-12);
}

TEST(OccupiedSpaceTest, RefusesWhatIsNoOctreeOfThisMap) {
  const TerrainQuery query = FloorQuery();
  octree_v1_t message = ExampleOctree();
  ++message.map_id;
  EXPECT_THROW(OccupiedSpace(message, query), std::runtime_error);
  message = ExampleOctree();
  message.data.pop_back();
  EXPECT_THROW(OccupiedSpace(message, query), std::runtime_error);
  message = ExampleOctree();
  message.box_max[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(OccupiedSpace(message, query), std::runtime_error);
  message = ExampleOctree();
  message.encoding = octree_v1_t::OCTOMAP_BT;
  EXPECT_THROW(OccupiedSpace(message, query), std::runtime_error);
}

TEST(OccupiedSpaceTest, FindsTheCubeThatALookAtManyPointsOfTheAxisFinds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1.0, 1.0), edge(0.02, 0.3);
  std::vector<Eigen::AlignedBox3d> cubes;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d low(place(random), place(random), place(random));
    cubes.emplace_back(low, low + Eigen::Vector3d::Constant(edge(random)));
  }
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-2, -2, -2), Eigen::Vector3d(2, 2, 2));
  const OccupiedSpace space(box, cubes);
  int num_through = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d a(place(random), place(random), place(random));
    const Eigen::Vector3d b = a + 0.5 * Eigen::Vector3d(place(random), place(random), place(random));
    constexpr int kPoints = 500;
    double slow = kEndless;
    for (int k = 0; k <= kPoints; ++k)
      for (const Eigen::AlignedBox3d& cube : cubes)
        slow = std::min(slow, cube.exteriorDistance(Eigen::Vector3d(a + (b - a) * (1.0 * k / kPoints))));
    const auto found = space.NearestTo(a, b, kEndless);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->away_world.norm(), 1.0, 1e-12);
    EXPECT_NEAR(std::max(0.0, found->distance_m), slow, 2e-3) << i;
    num_through += found->distance_m < 0.0 ? 1 : 0;
    EXPECT_EQ(space.NearestTo(a, b, 0.5 * slow).has_value(), found->distance_m <= 0.5 * slow);
  }
  EXPECT_GT(num_through, 10);
}

}  // namespace
}  // namespace terrace
