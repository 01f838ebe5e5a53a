// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/place_finder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/view_keeper.h"
#include "odometry/rotation.h"
#include "test/odometry/textured_walls.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

Eigen::Isometry3d At(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

PoseEstimate PoseAt(const Eigen::Isometry3d& T_world_left) {
  PoseEstimate pose;
  pose.status = TrackingStatus::kTracking;
  pose.trusted = true;
  pose.T_world_left = T_world_left;
  return pose;
}

std::vector<PlaceView> ViewOf(const StereoFrame& frame, const Eigen::Isometry3d& T_map_left) {
  ViewKeeper keeper(kVgaCamera);
  keeper.Add(frame, PoseAt(T_map_left));
  return keeper.views();
}

/// Up is -y of a level camera whose axes are those of the world.
Gravity AlongY() {
  Gravity gravity;
  gravity.down_world = Eigen::Vector3d::UnitY();
  gravity.sigma_rad = 0.005;
  return gravity;
}

class PlaceFinderTest : public ::testing::Test {
 protected:
  std::optional<CameraInMap> Look(const Eigen::Vector2d& camera_m, int wall = 0) {
    const StereoFrame frame = TexturedWall(camera_m, wall);
    return finder_.Look(frame, PoseAt(At(camera_m.x(), camera_m.y(), 0.0)), AlongY(), AlongY());
  }
  PlaceFinder finder_{kVgaCamera};
};

TEST_F(PlaceFinderTest, FindsTheCameraInTheMapWhenTwoFramesSayTheSame) {
  // The world began where the map has (7, 0, 3).
  finder_.Seek(ViewOf(TexturedWall({0.0, 0.0}), At(7.0, 0.0, 3.0)));
  EXPECT_FALSE(Look({0.20, 0.0}));
  EXPECT_THAT(finder_.reason(), HasSubstr("next one"));
  const auto camera = Look({0.25, 0.05});
  ASSERT_TRUE(camera) << finder_.reason();
  const Eigen::Vector3d error = camera->T_map_left.translation() - Eigen::Vector3d(7.25, 0.05, 3.0);
  EXPECT_LT(error.norm(), 0.03);
  EXPECT_LT(LogRotation(camera->T_map_left.linear()).norm(), 0.01);
  Vector6d whole;
  whole << LogRotation(camera->T_map_left.linear()), error;
  EXPECT_LT(whole.dot(camera->covariance.inverse() * whole), 20.0) << "not as exact as it says";
}

TEST_F(PlaceFinderTest, SaysThatNothingOfItIsKnown) {
  finder_.Seek(ViewOf(TexturedWall({0.0, 0.0}), At(7.0, 0.0, 3.0)));
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(Look({0.1 * i, 0.0}, 3));
  EXPECT_THAT(finder_.reason(), HasSubstr("nothing that is seen is known"));
}

TEST_F(PlaceFinderTest, ChoosesNoneOfTwoPlacesThatLookAlike) {
  std::vector<PlaceView> views = ViewOf(TexturedWall({0.0, 0.0}), At(7.0, 0.0, 3.0));
  views.push_back(ViewOf(TexturedWall({0.05, 0.0}), At(-4.0, 0.0, 1.0)).front());
  finder_.Seek(views);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(Look({0.03 * i, 0.0}));
  EXPECT_THAT(finder_.reason(), HasSubstr("several places"));
}

TEST_F(PlaceFinderTest, DoesNotTurnUpAside) {
  Eigen::Isometry3d rolled = At(7.0, 0.0, 3.0);
  rolled.linear() = ExpRotation({0.0, 0.0, 0.2});
  finder_.Seek(ViewOf(TexturedWall({0.0, 0.0}), rolled));
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(Look({0.03 * i, 0.0}));
  EXPECT_THAT(finder_.reason(), HasSubstr("up would be off by 11 deg"));
}

TEST_F(PlaceFinderTest, SaysThatABlankImageShowsTooLittle) {
  finder_.Seek(ViewOf(TexturedWall({0.0, 0.0}), At(7.0, 0.0, 3.0)));
  StereoFrame blank = TexturedWall({0.0, 0.0});
  blank.left.setTo(90);
  blank.right.setTo(90);
  EXPECT_FALSE(finder_.Look(blank, PoseAt(At(0, 0, 0)), AlongY(), AlongY()));
  EXPECT_THAT(finder_.reason(), HasSubstr("too little"));
}

}  // namespace
}  // namespace terrace
