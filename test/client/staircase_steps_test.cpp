// SPDX-License-Identifier: BSD-3-Clause
#include "client/staircase_steps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "test/client/made_terrain.h"

namespace terrace {
namespace {

/// Four risers of 0.17 m from x = 2 on, treads of 0.3 m, 1 m wide about y = 0, up along x; three treads.
Staircase StraightStairs() {
  Staircase stairs;
  stairs.id = 5;
  stairs.num_risers = 4;
  stairs.num_treads = 3;
  stairs.riser_m = 0.17;
  stairs.riser_sigma_m = 0.002;
  stairs.tread_m = 0.3;
  stairs.tread_sigma_m = 0.004;
  stairs.width_m = 1.0;
  stairs.foot_edge_world = {Eigen::Vector3d(2, 0.5, 0), Eigen::Vector3d(2, -0.5, 0)};
  stairs.head_edge_world = {Eigen::Vector3d(2.9, 0.5, 0.68), Eigen::Vector3d(2.9, -0.5, 0.68)};
  return stairs;
}

std::shared_ptr<TerrainRegion> Tread(std::int64_t id, int k, double z) {
  auto tread = MadeRegion(id, TerrainLabel::kStairTread, LevelAt(z),
                          Rectangle(2.0 + 0.3 * (k - 1), -0.5, 2.0 + 0.3 * k, 0.5));
  tread->staircase_id = 5;
  tread->step_index = k;
  return tread;
}

TEST(StaircaseStepsTest, SeenStepsStandAtTheirRegionsHeightAndOthersWhereTheLawHasThem) {
  Staircase stairs = StraightStairs();
  auto guessed = Tread(3, 3, 0.51);
  guessed->source = RegionSource::kPredicted;
  stairs.region_ids = {1, 3};
  const auto map = MadeMap({Tread(1, 1, 0.175), guessed});
  const StairPlan plan = StepsOf(TerrainQuery(map), stairs);
  ASSERT_EQ(plan.steps.size(), 4u);
  for (int k = 1; k <= 4; ++k) {
    const StairStep& step = plan.steps[static_cast<std::size_t>(k - 1)];
    EXPECT_EQ(step.index, k);
    EXPECT_EQ(step.landing, k == 4);
    EXPECT_NEAR(step.T_world_step.translation().x(), 2.0 + 0.3 * (k - 1), 1e-9);
    EXPECT_NEAR(step.T_world_step.translation().y(), 0.0, 1e-9);
    EXPECT_NEAR(step.T_world_step.translation().z(), k == 1 ? 0.175 : 0.17 * k, 1e-9);
    EXPECT_NEAR(step.width_m, 1.0, 1e-9);
    EXPECT_NEAR(step.depth_m, 0.3, 1e-9);
    EXPECT_EQ(step.seen, k == 1);
    EXPECT_TRUE(step.T_world_step.linear().isApprox(Eigen::Matrix3d::Identity()));
  }
  EXPECT_EQ(plan.steps[0].region_id, 1);
  EXPECT_EQ(plan.steps[2].region_id, 3) << "predicted";
  EXPECT_FALSE(plan.steps[1].region_id);
  EXPECT_DOUBLE_EQ(plan.steps[1].sigma_height_m, 0.004);
  EXPECT_GT(plan.steps[0].sigma_height_m, 0.0);
}

TEST(StaircaseStepsTest, SaysWhereToStandAndWhetherTheGroundThereIsKnown) {
  const auto floor = MadeRegion(9, TerrainLabel::kWalkway, LevelAt(0.01), Rectangle(0, -1, 2, 1));
  const StairPlan plan = StepsOf(TerrainQuery(MadeMap({floor})), StraightStairs(), 0.4);
  EXPECT_TRUE(plan.before.point_world.isApprox(Eigen::Vector3d(1.6, 0, 0.01)));
  ASSERT_TRUE(plan.before.ground);
  EXPECT_EQ(plan.before.ground->region_id, 9);
  EXPECT_TRUE(plan.before.heading_up.isApprox(Eigen::Vector2d::UnitX()));
  EXPECT_TRUE(plan.after.point_world.isApprox(Eigen::Vector3d(3.3, 0, 0.68)));
  EXPECT_FALSE(plan.after.ground) << "the landing has not been seen";
}

TEST(StaircaseStepsTest, StepsOfASpiralTurnAboutItsAxis) {
  // The axis stands at (0, 2); from radius 0.5 to 1.5; the foot edge points from the axis along -y; 20 deg a
  // step.
  constexpr double kTurn = 20.0 * M_PI / 180.0;
  const Eigen::Vector2d axis(0, 2);
  const auto nose = [&](int k, double radius, double z) {
    const Eigen::Vector2d p = axis + Eigen::Rotation2Dd(kTurn * (k - 1)) * Eigen::Vector2d(0, -radius);
    return Eigen::Vector3d(p.x(), p.y(), z);
  };
  Staircase stairs = StraightStairs();
  stairs.num_risers = 6;
  stairs.turn_per_step_rad = kTurn;  // to the left: the axis is at the left
  stairs.foot_edge_world = {nose(1, 0.5, 0), nose(1, 1.5, 0)};
  stairs.head_edge_world = {nose(6, 0.5, 6 * 0.17), nose(6, 1.5, 6 * 0.17)};
  const StairPlan plan = StepsOf(TerrainQuery(MadeMap({})), stairs);
  ASSERT_EQ(plan.steps.size(), 6u);
  for (int k = 1; k <= 6; ++k) {
    const StairStep& step = plan.steps[static_cast<std::size_t>(k - 1)];
    EXPECT_TRUE(step.nose_world[0].isApprox(nose(k, 0.5, 0.17 * k), 1e-9));
    EXPECT_TRUE(step.nose_world[1].isApprox(nose(k, 1.5, 0.17 * k), 1e-9));
    // Up the stairs is square to the nose, and the left end is to the left.
    const Eigen::Vector3d along = step.nose_world[0] - step.nose_world[1];
    EXPECT_NEAR(step.T_world_step.linear().col(0).dot(along), 0.0, 1e-9);
    EXPECT_NEAR(step.T_world_step.linear().col(1).dot(along), 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace terrace
