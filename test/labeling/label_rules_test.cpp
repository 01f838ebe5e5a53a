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

}  // namespace
}  // namespace terrace
