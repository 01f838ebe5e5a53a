// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/true_ground.h"

#include <cmath>

#include <gtest/gtest.h>

#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

const Eigen::Vector3d kEast = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kNorth = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

TEST(TrueGroundTest, CarriesAFootWhoseDiscTouchesASurface) {
  TrueScene scene;
  scene.polygons.push_back(Rectangle(1, "other", {0, 0, 0}, kEast, kNorth, 25, 25));
  const TrueGround ground(scene);
  EXPECT_TRUE(ground.Carries({0.5, 0.5, 0.02}, 0.02, 0.025));
  EXPECT_FALSE(ground.Carries({0.5, 0.5, 0.03}, 0.02, 0.025));
  EXPECT_TRUE(ground.Carries({1.019, 0.5, 0.0}, 0.02, 0.025));
  EXPECT_FALSE(ground.Carries({1.021, 0.5, 0.0}, 0.02, 0.025));
  EXPECT_FALSE(ground.Carries({1.015, 1.015, 0.0}, 0.02, 0.025));  // 21 mm from the corner
}

TEST(TrueGroundTest, CarriesAFootOnARampByTheHeightOfItsPlaneThere) {
  TrueScene scene;
  const Eigen::Vector3d up(std::cos(0.4), 0, std::sin(0.4));
  scene.polygons.push_back(Rectangle(1, "ramp", {0, 0, 0}, up, kNorth, 50, 25));
  const TrueGround ground(scene);
  const Eigen::Vector3d p(1.0, 0.5, std::tan(0.4));
  EXPECT_TRUE(ground.Carries(p + 0.02 * kUp, 0.0, 0.025));
  EXPECT_FALSE(ground.Carries(p - 0.03 * kUp, 0.0, 0.025));
}

TEST(TrueGroundTest, FindsDropsWhereTheGroundBeyondIsLowerOrAbsent) {
  TrueScene scene;
  scene.polygons.push_back(Rectangle(1, "walkway", {0, 0, 0}, kEast, kNorth, 25, 25));
  EXPECT_EQ(TrueGround(scene).Drops().size(), 200u);  // 4 m of edge into nothing
  // Along one side each: level ground, ground 4 cm lower, ground 6 cm lower, and a wall.
  scene.polygons.push_back(Rectangle(2, "other", {1, 0, 0}, kEast, kNorth, 5, 25));
  scene.polygons.push_back(Rectangle(3, "other", {0, 1, -0.04}, kEast, kNorth, 25, 5));
  scene.polygons.push_back(Rectangle(4, "other", {-0.2, 0, -0.06}, kEast, kNorth, 5, 25));
  scene.polygons.push_back(Rectangle(5, "wall", {0.04, 0, 0}, kUp, kEast, 25, 24));
  int lower = 0, beside_wall = 0;
  for (const DropSample& drop : TrueGround(scene).Drops()) {
    lower += drop.outwards.isApprox(-kEast, 1e-9) && std::abs(drop.p.x()) < 1e-9;
    beside_wall += drop.outwards.isApprox(-kNorth, 1e-9) && drop.p.x() < 0.04;
  }
  EXPECT_EQ(lower, 50);
  EXPECT_EQ(beside_wall, 2);
  EXPECT_EQ(TrueGround(scene).Drops().size(), 52u);
}

TEST(TrueGroundTest, TakesTheFrontOfATreadForADropAndItsBackForNone) {
  TrueScene scene;
  for (int step = 0; step < 3; ++step) {
    const Eigen::Vector3d foot(0.28 * step, 0, 0.16 * step);
    scene.polygons.push_back(Rectangle(2 * step + 1, "stair_riser", foot, kUp, kNorth, 4, 25));
    scene.polygons.push_back(Rectangle(2 * step + 2, "stair_tread", foot + 0.16 * kUp, kEast, kNorth, 7, 25));
  }
  int front = 0, back = 0;
  for (const DropSample& drop : TrueGround(scene).Drops()) {
    front += drop.outwards.isApprox(-kEast, 1e-9);
    back += drop.outwards.isApprox(kEast, 1e-9);
  }
  EXPECT_EQ(front, 3 * 50);
  EXPECT_EQ(back, 50);  // of the topmost only
}

TEST(TrueGroundTest, AsksForNoDropsOfTrimAndOfWhatIsNotWalkable) {
  TrueScene scene;
  scene.polygons.push_back(Rectangle(1, "obstacle", {0, 0, 0.5}, kEast, kNorth, 10, 10));
  scene.polygons.push_back(Rectangle(2, "walkway", {2, 0, 0.5}, kEast, kNorth, 10, 10));
  scene.polygons[1].detail = true;
  EXPECT_TRUE(TrueGround(scene).Drops().empty());
}

}  // namespace
}  // namespace terrace
