// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/label_rules.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "core/angles.h"
#include "label_scene.h"

namespace terrace {
namespace {

/// What the top of a low box before the robot is called.
TerrainLabel LabelOfTop(double size_x, double size_y, double yaw_rad) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {2, 0, 0}, 6, 4);
  scene.AddBox({2, 0.5, 0}, size_x, size_y, 0.1, yaw_rad);
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update(), StandingAt(0.5, 0));
  for (const auto& region : map->regions)
    if (region->plane_world.normal.z() > 0.9 && region->plane_world.offset_m > 0.05) return region->label;
  return TerrainLabel::kUnknown;
}

TEST(LabelRulesTest, OffersALowTopOnlyWhereASquareToStandOnFits) {
  for (const double yaw_rad : {0.0, 0.4, 0.8}) {
    EXPECT_EQ(LabelOfTop(0.52, 0.52, yaw_rad), TerrainLabel::kWalkway) << yaw_rad;
    EXPECT_EQ(LabelOfTop(0.60, 0.47, yaw_rad), TerrainLabel::kObstacle) << yaw_rad;
    EXPECT_EQ(LabelOfTop(0.47, 0.47, yaw_rad), TerrainLabel::kObstacle) << yaw_rad;
  }
}

/// What level ground that goes on from a floor is called, when it leans so much, known so well.
std::shared_ptr<const TerrainRegion> MoreGround(double lean_deg, double sigma_deg) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {2, 0, 0}, 4, 3);
  const double rise = 0.3 * std::tan(Radians(lean_deg));
  scene.Add({{{4, -1, 0}, {4.3, -1, rise}, {4.3, 1, rise}, {4, 1, 0}}, {}, TerrainLabel::kUnknown});
  PolygonUpdate update = scene.Update();
  auto more = std::make_shared<Polygon>(*update.changed[1]);
  more->plane_covariance.diagonal().head<2>().setConstant(std::pow(Radians(sigma_deg), 2));
  update.changed[1] = more;
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, update, StandingAt(0.5, 0));
  for (const auto& region : map->regions)
    if (region->id == more->id) return region;
  return nullptr;
}

TEST(LabelRulesTest, OffersGroundOnlyWhereItIsKnownHowItLeans) {
  ASSERT_TRUE(MoreGround(2.0, 1.0));
  EXPECT_EQ(MoreGround(2.0, 1.0)->label, TerrainLabel::kWalkway);
  EXPECT_EQ(MoreGround(2.0, 6.0)->label, TerrainLabel::kUnknown);
  EXPECT_EQ(MoreGround(2.0, 6.0)->why, "slope not known");
  EXPECT_EQ(MoreGround(11.0, 1.0)->label, TerrainLabel::kUnknown) << "it rises little, but is too steep";
}

TEST(LabelRulesTest, TakesTheFirstStripOfALandingForNoObstacleAndTheLandingForAWalkwayAtOnce) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 2);
  KnownFlight flight;
  flight.foot = {3, 0, 0};
  scene.AddFlight(flight);
  const double head_x = 3 + 5 * flight.run_m, head_z = 6 * flight.rise_m;
  TerrainLabeler labeler = MakeLabeler();
  const PoseEstimate climbing = StandingAt(3.5, 0, 0.34);
  LabelOften(labeler, scene.Update(), climbing);
  LabelScene strip = scene;
  strip.AddLevel(TerrainLabel::kUnknown, {head_x + 0.08, 0, head_z}, 0.16, 1.4);
  const auto label = [&](const LabelScene& seen) {
    const TerrainMapPtr map = LabelOften(labeler, seen.Update(), climbing, 1);
    for (const auto& region : map->regions)
      if (region->id == static_cast<std::int64_t>(seen.pieces.size())) return region->label;
    return TerrainLabel::kWall;
  };
  EXPECT_NE(label(strip), TerrainLabel::kObstacle);
  LabelScene landing = scene;
  landing.AddLevel(TerrainLabel::kWalkway, {head_x + 0.5, 0, head_z}, 1.0, 1.4);
  EXPECT_EQ(label(landing), TerrainLabel::kWalkway);
  LabelScene thing = landing;
  thing.AddLevel(TerrainLabel::kObstacle, {3 + 2.5 * flight.run_m, 0, 3 * flight.rise_m + 0.1}, 0.15, 0.4);
  EXPECT_EQ(label(thing), TerrainLabel::kObstacle) << "it lies on the third tread";
}

}  // namespace
}  // namespace terrace
