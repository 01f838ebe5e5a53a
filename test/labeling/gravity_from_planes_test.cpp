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

Gravity KnownTo(double sigma_rad) {
  Gravity gravity = TestGravity();
  gravity.sigma_rad = sigma_rad;
  return gravity;
}

TEST(GravityFromPlanesTest, IsTheNormalOfTheFloorAndNeverSurerThanFloorsAreLevel) {
  LabelScene scene;
  AddSlope(scene, 0.0, 2.0, Radians(1.0));
  const auto hint = GravityFromPlanes(scene.Update(), StandingAt(0, 0), KnownTo(Radians(1.0)));
  ASSERT_TRUE(hint);
  EXPECT_LT(AngleToNormal(*hint, Radians(1.0)), Radians(0.01));
  EXPECT_GE(hint->sigma_rad, Radians(0.3));
}

TEST(GravityFromPlanesTest, IsNotPulledByARampBesideTheFloor) {
  LabelScene scene;
  AddSlope(scene, 0.0, 3.0, 0.0);
  AddSlope(scene, 3.0, 1.0, Radians(6.0));
  const auto hint = GravityFromPlanes(scene.Update(), StandingAt(0, 0), KnownTo(Radians(3.0)));
  ASSERT_TRUE(hint);
  EXPECT_LT(AngleToNormal(*hint, 0.0), Radians(0.01));
}

TEST(GravityFromPlanesTest, AsksForALargePlaneNearLevel) {
  LabelScene small;
  AddSlope(small, 0.0, 0.1, 0.0);
  EXPECT_FALSE(GravityFromPlanes(small.Update(), StandingAt(0, 0), KnownTo(Radians(1.0))));
  LabelScene steep;
  AddSlope(steep, 0.0, 2.0, Radians(20.0));
  EXPECT_FALSE(GravityFromPlanes(steep.Update(), StandingAt(0, 0), KnownTo(Radians(1.0))));
  // While up is a guess, the floor may lean by much more.
  Gravity assumed = KnownTo(Radians(1.0));
  assumed.source = GravitySource::kAssumed;
  EXPECT_TRUE(GravityFromPlanes(steep.Update(), StandingAt(0, 0), assumed));
}

}  // namespace
}  // namespace terrace
