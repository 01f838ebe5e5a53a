// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/view_memory.h"

#include <cmath>

#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

constexpr double kFarthestJudged = 4.0;

/// From how near a scene of one piece is seen from each of the eyes in turn.
double NearestView(const LabelScene& scene, const std::vector<Eigen::Vector3d>& eyes) {
  ShapeTable table({0.52, 1.13, 0.5}, 0.003);
  table.Update(scene.Update(), TestGravity(), eyes.front());
  ViewMemory views(TestCamera(), kFarthestJudged);
  for (const Eigen::Vector3d& eye : eyes) {
    Eigen::Isometry3d T_level_left = TestBodyLeft();
    T_level_left.translation() = eye;
    views.Look(table, T_level_left, Timestamp{0});
  }
  return views.nearest_view_m().front();
}

TEST(ViewMemoryTest, MeasuresFromARampAndNotFromTheBoxAroundIt) {
  LabelScene scene;  // rises by a half from x = 2 to 6
  scene.Add({{{2, -1, 0}, {6, -1, 2}, {6, 1, 2}, {2, 1, 0}}, {}, TerrainLabel::kRamp});
  EXPECT_NEAR(NearestView(scene, {{3, 0, 1.5}}), 2.0 / std::sqrt(5.0), 1e-6) << "the eye is in the box";
  EXPECT_NEAR(NearestView(scene, {{0, 0, 0.5}}), std::hypot(2.0, 0.5), 1e-6);
}

TEST(ViewMemoryTest, MeasuresFromAFaceThatStandsAskew) {
  LabelScene scene;
  scene.AddFace(TerrainLabel::kWall, {3, 2, 0}, {5, 0, 0}, 1.0);
  EXPECT_NEAR(NearestView(scene, {{3, 0, 0.5}}), std::sqrt(2.0), 0.01);
}

TEST(ViewMemoryTest, RemembersTheNearestOfManyViews) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {4, 0, 0}, 2, 2);
  EXPECT_NEAR(NearestView(scene, {{0, 0, 0.5}, {2, 0, 0.5}, {1, 0, 0.5}}), std::hypot(1.0, 0.5), 1e-6);
}

}  // namespace
}  // namespace terrace
