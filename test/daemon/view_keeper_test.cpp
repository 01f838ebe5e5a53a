// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/view_keeper.h"

#include <gtest/gtest.h>

#include "test/odometry/textured_walls.h"

namespace terrace {
namespace {

PoseEstimate PoseBeside(double x_m) {
  PoseEstimate pose;
  pose.T_world_left.translation() << x_m, 0.0, 0.0;
  return pose;
}

TEST(ViewKeeperTest, KeepsOneViewOfEachPlace) {
  ViewKeeper keeper(kVgaCamera);
  const StereoFrame frame = TexturedWall({0.0, 0.0});
  for (const double x_m : {0.0, 0.1, 0.3, 0.5, 0.6, 0.2, 1.0}) keeper.Add(frame, PoseBeside(x_m));
  ASSERT_EQ(keeper.views().size(), 3u);
  EXPECT_EQ(keeper.views()[1].T_world_left.translation().x(), 0.5);
  EXPECT_EQ(keeper.views()[2].T_world_left.translation().x(), 1.0);
}

TEST(ViewKeeperTest, KeepsTwoViewsFromOnePlaceInTwoDirections) {
  ViewKeeper keeper(kVgaCamera);
  const StereoFrame frame = TexturedWall({0.0, 0.0});
  PoseEstimate turned = PoseBeside(0.0);
  turned.T_world_left.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()).toRotationMatrix();
  keeper.Add(frame, PoseBeside(0.0));
  keeper.Add(frame, turned);
  EXPECT_EQ(keeper.views().size(), 2u);
}

TEST(ViewKeeperTest, KeepsNothingOfABlankImage) {
  ViewKeeper keeper(kVgaCamera);
  StereoFrame blank = TexturedWall({0.0, 0.0});
  blank.left.setTo(90);
  keeper.Add(blank, PoseBeside(0.0));
  EXPECT_TRUE(keeper.views().empty());
}

TEST(ViewKeeperTest, TriesAPlaceThatShowedNothingAgainAfterSomeFrames) {
  ViewKeeper keeper(kVgaCamera);
  const StereoFrame frame = TexturedWall({0.0, 0.0});
  StereoFrame blank = frame;
  blank.left = cv::Mat1b(frame.left.size(), std::uint8_t{90});
  keeper.Add(blank, PoseBeside(0.0));
  keeper.Add(frame, PoseBeside(0.0));
  EXPECT_TRUE(keeper.views().empty());
  for (int i = 0; i < 20; ++i) keeper.Add(frame, PoseBeside(0.0));
  EXPECT_EQ(keeper.views().size(), 1u);
}

TEST(ViewKeeperTest, StaysBoundedAndKeepsTheFirstAndTheNewest) {
  ViewKeeper keeper(kVgaCamera, 6);
  const StereoFrame frame = TexturedWall({0.0, 0.0});
  for (int i = 0; i < 20; ++i) keeper.Add(frame, PoseBeside(i));
  EXPECT_LE(keeper.views().size(), 6u);
  EXPECT_EQ(keeper.views().front().T_world_left.translation().x(), 0.0);
  EXPECT_EQ(keeper.views().back().T_world_left.translation().x(), 19.0);
}

}  // namespace
}  // namespace terrace
