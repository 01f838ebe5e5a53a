// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/point_places.h"

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include <gmock/gmock.h>

#include "mapping/point_summing.h"
#include "test/every_target.h"

namespace terrace {
namespace {

StereoCamera PlacingCamera() {
  StereoCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 400.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  camera.baseline_m = 0.1;
  return camera;
}

Eigen::Isometry3d AnyPose() {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  T_world_left.linear() =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
  T_world_left.translation() << -7.013, 41.377, 0.501;
  return T_world_left;
}

/// A frame's worth of points in front of the camera, near and far, so that every level is used.
std::vector<CloudPoint> AnyPoints() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-1.0F, 1.0F);
  std::vector<CloudPoint> points(PlacedPoints::kMost - 3);
  for (CloudPoint& point : points) {
    const float z = 3.1F + 3.0F * any(random);
    point = {{0.7F * z * any(random), 0.5F * z * any(random), z}, 0, 0, 0.002F * z * z};
  }
  return points;
}

/// The definition, point by point and in double precision.
struct SlowPlace {
  LeafAddress address;
  Eigen::Vector3d offset_m;
  double weight;
};

SlowPlace SlowlyPlaced(const CloudPoint& point, const MappingConfig& config) {
  const StereoCamera camera = PlacingCamera();
  int level = 0;
  while (level < CoarsestLevel(config.leaves_per_cell) &&
         config.leaf_size_m * (1 << level) * camera.fx / point.p_left.z() < config.min_leaf_px)
    ++level;
  const Eigen::Vector3d p_world = AnyPose() * point.p_left.cast<double>();
  LeafIndex corner = LeafAt(p_world, config);
  for (int i = 0; i < 3; ++i) corner[i] = corner[i] >> level << level;
  const Eigen::Vector3d centre =
      config.leaf_size_m * (corner.cast<double>() + Eigen::Vector3d::Constant(0.5 * (1 << level)));
  const double sigma = config.depth_sigma_factor * point.sigma_depth_m;
  return {LeafAddress(corner, level), p_world - centre,
          1.0 / (sigma * sigma + config.pose_sigma_m * config.pose_sigma_m)};
}

TEST(PointPlacesTest, PointsFallIntoTheLeafThatHoldsThemAtTheLevelOfTheirDepth) {
  const MappingConfig config;
  const std::vector<CloudPoint> points = AnyPoints();
  PlacedPoints placed;
  PointPlacer(PlacingCamera(), AnyPose(), config).Place(points.data(), points.size(), &placed);
  std::vector<int> of_level(8, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const SlowPlace slow = SlowlyPlaced(points[i], config);
    ++of_level[static_cast<std::size_t>(slow.address.level())];
    EXPECT_EQ(placed.Address(i), slow.address) << i;
    EXPECT_NEAR(placed.x_m[i], slow.offset_m.x(), 2e-6);
    EXPECT_NEAR(placed.y_m[i], slow.offset_m.y(), 2e-6);
    EXPECT_NEAR(placed.z_m[i], slow.offset_m.z(), 2e-6);
    EXPECT_NEAR(placed.weight[i], slow.weight, 1e-5 * slow.weight);
    EXPECT_NEAR(placed.disparity_px[i], 40.0F / points[i].p_left.z(), 1e-4);
  }
  for (int level = 0; level <= CoarsestLevel(config.leaves_per_cell); ++level)
    EXPECT_GT(of_level[static_cast<std::size_t>(level)], 0) << "no point tries level " << level;
}

TEST(PointPlacesTest, WhatIsNoNumberOrBehindOrTooFarAwayLiesInNoLeaf) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const std::vector<CloudPoint> points = {
      {{0.1F, 0.2F, nan}, 0, 0, 0.01F},      {{nan, 0.2F, 2.0F}, 0, 0, 0.01F},
      {{0.1F, 0.2F, 2.0F}, 0, 0, nan},       {{0.1F, 0.2F, -2.0F}, 0, 0, 0.01F},
      {{0.1F, 0.2F, infinite}, 0, 0, 0.01F}, {{0.1F, 0.2F, 1e6F}, 0, 0, 0.01F},
      {{0.1F, 0.2F, 2.0F}, 0, 0, 0.01F}};
  PlacedPoints placed;
  PointPlacer(PlacingCamera(), AnyPose(), {}).Place(points.data(), points.size(), &placed);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) EXPECT_EQ(placed.weight[i], 0.0F) << i;
  EXPECT_GT(placed.weight[points.size() - 1], 0.0F);
}

TEST(PointPlacesTest, GivesTheSameBitsOnEveryInstructionSet) {
  const std::vector<CloudPoint> points = AnyPoints();
  std::optional<PlacedPoints> first;
  OnEveryTarget([&] {
    PlacedPoints placed;
    PointPlacer(PlacingCamera(), AnyPose(), {}).Place(points.data(), points.size(), &placed);
    if (!first) first = placed;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(placed.Address(i), first->Address(i));
      EXPECT_EQ(placed.x_m[i], first->x_m[i]);
      EXPECT_EQ(placed.y_m[i], first->y_m[i]);
      EXPECT_EQ(placed.z_m[i], first->z_m[i]);
      EXPECT_EQ(placed.weight[i], first->weight[i]);
      EXPECT_EQ(placed.disparity_px[i], first->disparity_px[i]);
    }
  });
}

}  // namespace
}  // namespace terrace
