// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/elevation_map.h"

#include <cmath>

#include <gtest/gtest.h>

#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

const StereoCamera kYardstickCamera{200, 200, 200.0, 200.0, 99.5, 99.5, 0.1};

/// Looks straight down from `height_m` above the origin: x right, y up in the image.
Eigen::Isometry3d LookingDown(double height_m) {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  T_world_left.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  T_world_left.translation() = Eigen::Vector3d(0, 0, height_m);
  return T_world_left;
}

/// What that camera sees of ground whose height is a function of the place.
template <typename Height>
FloatImage Seen(double camera_m, Height height) {
  FloatImage image(kYardstickCamera.width, kYardstickCamera.height);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const double x = (u - kYardstickCamera.cx) / kYardstickCamera.fx,
                   y = -(v - kYardstickCamera.cy) / kYardstickCamera.fy;
      double depth = camera_m;
      // The ray meets the ground where its height is what is left of the camera's.
      for (int i = 0; i < 20; ++i) depth = camera_m - height(depth * x, depth * y);
      image.At(u, v) = static_cast<float>(kYardstickCamera.Disparity(depth));
    }
  }
  return image;
}

TEST(ElevationMapTest, FusesALevelFloorAndOffersAllOfIt) {
  ElevationMap map;
  for (int frame = 0; frame < 3; ++frame)
    map.Add(Seen(1.0, [](double, double) { return 0.2; }), kYardstickCamera, LookingDown(1.0));
  map.FindFootholds();
  EXPECT_NEAR(map.HeightAt({0.1, 0.1}).value(), 0.2, 1e-4);
  EXPECT_FALSE(map.HeightAt({2.0, 0.0}));
  EXPECT_TRUE(map.OfferAt({0.1, 0.1, 0.21}, 0.025));
  EXPECT_FALSE(map.OfferAt({0.1, 0.1, 0.23}, 0.025));
  double area_m2 = 0.0;
  map.ForEach([&](const Eigen::Vector3d& p, bool) {
    EXPECT_NEAR(p.z(), 0.2, 1e-4);
    area_m2 += 1e-4;
  });
  // 0.8 m below the camera the image shows 0.8 x 0.8 m; the rim of one cell has no neighbours.
  EXPECT_NEAR(area_m2, 0.76 * 0.76, 0.04);
}

TEST(ElevationMapTest, FollowsASlopeThatCanBeWalkedAndNoneThatIsSteeper) {
  for (const double slope : {0.3, 0.7}) {
    ElevationMap map;
    map.Add(Seen(1.0, [&](double x, double) { return slope * x; }), kYardstickCamera, LookingDown(1.0));
    map.FindFootholds();
    EXPECT_EQ(map.OfferAt({0.11, 0.11, slope * 0.11}, 0.005), slope < 0.5) << slope;
  }
}

TEST(ElevationMapTest, OffersNothingWithinACellOfAStep) {
  ElevationMap map;
  map.Add(Seen(1.0, [](double x, double) { return x > 0.1 ? 0.1 : 0.0; }), kYardstickCamera,
          LookingDown(1.0));
  map.FindFootholds();
  EXPECT_TRUE(map.OfferAt({0.05, 0.0, 0.0}, 0.01));
  EXPECT_FALSE(map.OfferAt({0.09, 0.0, 0.0}, 0.01));
  EXPECT_FALSE(map.OfferAt({0.11, 0.0, 0.1}, 0.01));
  EXPECT_TRUE(map.OfferAt({0.17, 0.0, 0.1}, 0.01));
}

TEST(ElevationMapTest, IsNotMovedByASingleFalseHeight) {
  ElevationMap map;
  const auto floor = Seen(1.0, [](double, double) { return 0.0; });
  for (int frame = 0; frame < 3; ++frame) map.Add(floor, kYardstickCamera, LookingDown(1.0));
  map.Add(Seen(1.0, [](double, double) { return 0.3; }), kYardstickCamera, LookingDown(1.0));
  EXPECT_NEAR(map.HeightAt({0.1, 0.1}).value(), 0.0, 1e-4);
}

TEST(ElevationMapTest, IsJudgedLikeRegions) {
  TrueScene truth;
  truth.polygons.push_back(
      Rectangle(1, "walkway", {-0.2, -0.2, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 10, 10));
  ElevationMap map;
  map.Add(Seen(1.0, [](double, double) { return 0.0; }), kYardstickCamera, LookingDown(1.0));
  map.FindFootholds();
  const FeetEvaluation feet = EvaluateFootholds(map, truth, {{1, truth.polygons[0].observed}});
  EXPECT_NEAR(*feet.offered_pct(), 100.0, 1e-9);
  // The map goes on where there is nothing: all but the 0.4 m of floor and the 2 cm around it.
  EXPECT_NEAR(*feet.unsupported_pct(), 100.0 * (1.0 - 0.44 * 0.44 / (0.96 * 0.96)), 2.0);
}

}  // namespace
}  // namespace terrace
