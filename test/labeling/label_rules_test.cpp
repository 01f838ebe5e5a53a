// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/label_rules.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace terrace
