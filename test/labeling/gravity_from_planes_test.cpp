// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/gravity_from_planes.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/angles.h"
#include "label_scene.h"

namespace terrace {
namespace {

/// A square that leans about y.
void AddSlope(LabelScene& scene, double x, double size_m, double slope_rad) {
  const double up = size_m * std::tan(slope_rad);
  scene.Add({{{x, -1, 0}, {x + size_m, -1, up}, {x + size_m, 1, up}, {x, 1, 0}}, {}, TerrainLabel::kWalkway});
}

double AngleToNormal(const GravityHint& hint, double slope_rad) {
  const Eigen::Vector3d up(-std::sin(slope_rad), 0.0, std::cos(slope_rad));
  return std::acos(std::min(1.0, -hint.down_world.dot(up)));
}

std::optional<GravityHint> HintOf(const LabelScene& scene, const Gravity& gravity) {
  LevelPlanes planes;
  planes.Update(scene.Update());
  return planes.Hint(gravity);
}

Gravity KnownTo(double sigma_rad) {
  Gravity gravity = TestGravity();
  gravity.sigma_rad = sigma_rad;
  return gravity;
}

TEST(LevelPlanesTest, SaysTheNormalOfTheFloorAndNeverSurerThanFloorsAreLevel) {
  LabelScene scene;
  AddSlope(scene, 0.0, 2.0, Radians(1.0));
  const auto hint = HintOf(scene, KnownTo(Radians(1.0)));
  ASSERT_TRUE(hint);
  EXPECT_LT(AngleToNormal(*hint, Radians(1.0)), Radians(0.01));
  EXPECT_GE(hint->sigma_rad, Radians(0.3));
}

TEST(LevelPlanesTest, IsNotPulledByARampBesideTheFloor) {
  LabelScene scene;
  AddSlope(scene, 0.0, 3.0, 0.0);
  AddSlope(scene, 3.0, 1.0, Radians(6.0));
  const auto hint = HintOf(scene, KnownTo(Radians(3.0)));
  ASSERT_TRUE(hint);
  EXPECT_LT(AngleToNormal(*hint, 0.0), Radians(0.01));
}

TEST(LevelPlanesTest, AsksForALargePlaneNearLevel) {
  LabelScene small;
  AddSlope(small, 0.0, 0.1, 0.0);
  EXPECT_FALSE(HintOf(small, KnownTo(Radians(1.0))));
  LabelScene steep;
  AddSlope(steep, 0.0, 2.0, Radians(20.0));
  EXPECT_FALSE(HintOf(steep, KnownTo(Radians(1.0))));
  // While up is a guess, the floor may lean by much more.
  Gravity assumed = KnownTo(Radians(1.0));
  assumed.source = GravitySource::kAssumed;
  EXPECT_TRUE(HintOf(steep, assumed));
}

TEST(LevelPlanesTest, FollowsPlanesThatChangeAndGo) {
  LabelScene scene;
  AddSlope(scene, 0.0, 2.0, Radians(1.0));
  AddSlope(scene, 3.0, 1.0, Radians(2.0));
  LevelPlanes planes;
  planes.Update(scene.Update());
  const Gravity known = KnownTo(Radians(1.0));
  EXPECT_LT(AngleToNormal(*planes.Hint(known), Radians(1.5)), Radians(0.1));
  PolygonUpdate update;
  update.removed = {1};
  planes.Update(update);
  EXPECT_LT(AngleToNormal(*planes.Hint(known), Radians(2.0)), Radians(0.01));
  // What shrinks says nothing any more.
  auto small = std::make_shared<Polygon>(*scene.Update().changed[1]);
  small->area_m2 = 0.1;
  update = {};
  update.changed = {small};
  planes.Update(update);
  EXPECT_FALSE(planes.Hint(known));
}

}  // namespace
}  // namespace terrace
