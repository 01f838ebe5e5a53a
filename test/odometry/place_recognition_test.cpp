// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/place_recognition.h"

#include <gtest/gtest.h>

#include "odometry/rotation.h"
#include "textured_walls.h"

namespace terrace {
namespace {

std::vector<PlaceCorner> CornersOf(const std::vector<DescribedFeature>& features) {
  std::vector<PlaceCorner> corners;
  for (const DescribedFeature& feature : features)
    corners.push_back(
        {kVgaCamera.Triangulate(feature.uvd.x(), feature.uvd.y(), feature.uvd.z()), feature.descriptor});
  return corners;
}

TEST(PlaceRecognitionTest, KnowsHowFarTheCornersOfAFrameAre) {
  const auto features = DescribeFrame(TexturedWall({0.0, 0.0}), kVgaCamera, 0.0);
  ASSERT_GT(features.size(), 100u);
  for (const DescribedFeature& feature : features)
    EXPECT_NEAR(kVgaCamera.Depth(feature.uvd.z()), kWallDistance_m, 0.05);
}

TEST(PlaceRecognitionTest, SaysWhereTheCameraIsAmongCornersOfAnotherFrame) {
  const auto corners = CornersOf(DescribeFrame(TexturedWall({0.0, 0.0}), kVgaCamera, 0.0));
  Eigen::Isometry3d T_world_host = Eigen::Isometry3d::Identity();
  T_world_host.linear() = ExpRotation({0.1, 0.9, -0.3});
  T_world_host.translation() << 5.0, 1.0, -2.0;
  const auto solution = Recognize(DescribeFrame(TexturedWall({0.25, -0.1}), kVgaCamera, 0.0), corners,
                                  T_world_host, kVgaCamera, 1);
  ASSERT_TRUE(solution);
  const Eigen::Isometry3d T_host_left = T_world_host.inverse() * solution->T_world_left;
  EXPECT_LT((T_host_left.translation() - Eigen::Vector3d(0.25, -0.1, 0.0)).norm(), 0.02);
  EXPECT_LT(LogRotation(T_host_left.linear()).norm(), 0.01);
}

TEST(PlaceRecognitionTest, DoesNotRecogniseWhatItHasNotSeen) {
  const auto corners = CornersOf(DescribeFrame(TexturedWall({0.0, 0.0}), kVgaCamera, 0.0));
  for (int wall = 1; wall < 6; ++wall)
    EXPECT_FALSE(Recognize(DescribeFrame(TexturedWall({0.0, 0.0}, wall), kVgaCamera, 0.0), corners,
                           Eigen::Isometry3d::Identity(), kVgaCamera, 1))
        << wall;
}

}  // namespace
}  // namespace terrace
