// SPDX-License-Identifier: BSD-3-Clause
#include "client/example/footsteps/footstep_search.h"

#include <cmath>

#include <gtest/gtest.h>

#include "client/example/footsteps/plan_message.h"
#include "client/example/footsteps/plan_picture.h"
#include "lcmtypes/safe_decode.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

std::shared_ptr<TerrainRegion> Floor(std::int64_t id, double z, const PlanRing& ring,
                                     TerrainLabel label = TerrainLabel::kWalkway) {
  return MadeRegion(id, label, LevelAt(z), ring);
}

/// What must hold for every plan.
void ExpectWalkable(const Walker& walker, const std::vector<Footstep>& steps, const PlanEnd& goal) {
  ASSERT_GE(steps.size(), 2u);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Support& ground = steps[i].ground;
    EXPECT_TRUE(kWalkableLabels.Has(ground.label));
    EXPECT_GE(ground.edge_distance_m, walker.foot.radius_m - 3e-6);
    if (i == 0) continue;
    EXPECT_NE(steps[i].left, steps[i - 1].left);
    const Eigen::Vector3d step = ground.point_world - steps[i - 1].ground.point_world;
    EXPECT_LE(std::abs(step.z()), walker.max_step_height_m);
    EXPECT_LE(step.head<2>().norm(), std::hypot(walker.stance_width_m, walker.stride_m) + walker.snap_m);
  }
  const Eigen::Vector2d middle =
      0.5 * (steps.back().ground.point_world + steps[steps.size() - 2].ground.point_world).head<2>();
  EXPECT_LE((middle - goal.ground_world.head<2>()).norm(), 0.45);
}

TEST(FootstepSearchTest, ClimbsStairsToTheLanding) {
  std::vector<std::shared_ptr<const TerrainRegion>> regions{Floor(1, 0, Rectangle(-1, -1, 1, 1))};
  for (int k = 1; k <= 5; ++k) {
    regions.push_back(
        Floor(1 + k, 0.15 * k, Rectangle(1 + 0.3 * (k - 1), -1, 1 + 0.3 * k, 1), TerrainLabel::kStairTread));
  }
  regions.push_back(Floor(9, 0.9, Rectangle(2.5, -1, 4.5, 1)));
  const TerrainQuery query(MadeMap(regions));
  const Walker walker;
  const PlanEnd goal{{3.5, 0, 0.9}, 0.0};
  const auto steps = PlanFootsteps(query, walker, {{0, 0, 0}, 0.0}, goal);
  ExpectWalkable(walker, steps, goal);
  EXPECT_NEAR(steps.back().ground.point_world.z(), 0.9, 1e-9);

  const footstep_plan_v1_t plan = PlanMessage(query.map(), steps, walker.foot.radius_m);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(plan.getEncodedSize()));
  plan.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  const auto read = SafeDecode<footstep_plan_v1_t>(bytes.data(), bytes.size());
  ASSERT_TRUE(read);
  ASSERT_EQ(read->pos.size(), steps.size());
  EXPECT_EQ(read->map_seq, query.map().seq);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(read->pos[i][2], steps[i].ground.point_world.z());
    EXPECT_EQ(read->side[i] == footstep_plan_v1_t::LEFT, steps[i].left);
    // It climbs from the first foot on a tread to the first one that leaves the treads.
    const auto on_tread = [&](std::size_t k) { return steps[k].ground.label == TerrainLabel::kStairTread; };
    EXPECT_EQ(read->gait[i] == footstep_plan_v1_t::CLIMB, on_tread(i) || (i > 0 && on_tread(i - 1))) << i;
  }
}

TEST(FootstepSearchTest, GoesRoundAWallAndNotThroughIt) {
  const auto floor = Floor(1, 0, Rectangle(-0.5, -0.8, 3, 1.4));
  // An upright face across the way, open at y > 0.5.
  auto wall = std::make_shared<TerrainRegion>(*Floor(2, 0, Rectangle(0, 0, 1, 1)));
  wall->label = TerrainLabel::kWall;
  wall->plane_world = {-Eigen::Vector3d::UnitX(), -1.5};
  wall->outline_world = {{1.5, 0.5, 0}, {1.5, -2, 0}, {1.5, -2, 2}, {1.5, 0.5, 2}};
  wall->centroid_world = {1.5, -0.6, 1};
  const TerrainQuery query(MadeMap({floor, wall}));
  const Walker walker;
  const PlanEnd goal{{2.5, 0, 0}, 0.0};
  const auto steps = PlanFootsteps(query, walker, {{0, 0, 0}, 0.0}, goal);
  ExpectWalkable(walker, steps, goal);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const Eigen::Vector3d a = steps[i - 1].ground.point_world, b = steps[i].ground.point_world;
    const double share = (1.5 - a.x()) / (b.x() - a.x());
    if (share < 0.0 || share > 1.0) continue;
    EXPECT_GT(a.y() + share * (b.y() - a.y()), 0.5 - 0.5 * walker.stance_width_m)
        << "the line from foot to foot passes the wall no nearer than half the stance";
  }
}

TEST(FootstepSearchTest, FindsNoWayAcrossAGapThatIsTooWideOrUpAStepThatIsTooHigh) {
  const Walker walker;
  const PlanEnd start{{0, 0, 0}, 0.0};
  const auto near = Floor(1, 0, Rectangle(-0.3, -0.4, 1, 0.4));
  const auto far = Floor(2, 0, Rectangle(1.8, -1, 4, 1));
  EXPECT_TRUE(PlanFootsteps(TerrainQuery(MadeMap({near, far})), walker, start, {{3, 0, 0}, 0.0}).empty());
  const auto high = Floor(2, 0.25, Rectangle(1, -1, 4, 1));
  EXPECT_TRUE(PlanFootsteps(TerrainQuery(MadeMap({near, high})), walker, start, {{3, 0, 0.25}, 0.0}).empty());
  const auto low = Floor(2, 0.15, Rectangle(1, -1, 4, 1));
  EXPECT_FALSE(PlanFootsteps(TerrainQuery(MadeMap({near, low})), walker, start, {{3, 0, 0.15}, 0.0}).empty());
}

TEST(FootstepSearchTest, ThePictureHasEveryFootAndEveryPieceOfGround) {
  const auto map = MadeMap({Floor(1, 0, Rectangle(-1, -1, 1, 1))});
  const auto steps = PlanFootsteps(TerrainQuery(map), {}, {{-0.5, 0, 0}, 0.0}, {{0.5, 0, 0}, 0.0});
  const std::string svg = PlanPicture(*map, steps, 0.03);
  std::size_t num_circles = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1))
    ++num_circles;
  EXPECT_EQ(num_circles, steps.size());
  EXPECT_NE(svg.find("<path"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace terrace
