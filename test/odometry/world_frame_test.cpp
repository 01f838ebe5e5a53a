// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/world_frame.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// Camera 0.5 m above the body's origin, looking forward and down by `pitch`.
Eigen::Isometry3d PitchedMounting(double pitch_rad) {
  Eigen::Matrix3d R_body_level;  // x right, y down, z forward in body axes
  R_body_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R_body_level * Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T.translation() << 0.2, 0.0, 0.5;
  return T;
}

TEST(WorldFrameTest, TakesTheRobotAsStandingLevelWhenOnlyItsMountingIsKnown) {
  Mounting mounting;
  mounting.T_body_left = PitchedMounting(0.35);
  const WorldFrame world = LayWorldFrame({}, mounting, {});
  EXPECT_EQ(world.gravity.source, GravitySource::kMounting);
  EXPECT_TRUE(world.T_world_left.isApprox(*mounting.T_body_left, 1e-12));
  EXPECT_TRUE(world.warning.empty());
}

TEST(WorldFrameTest, RefusesABodyThatIsASensorWithOneWarning) {
  Mounting mounting;
  mounting.T_body_left = Eigen::Isometry3d::Identity();
  mounting.T_body_left->linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const WorldFrame world = LayWorldFrame({}, mounting, {});
  EXPECT_EQ(world.gravity.source, GravitySource::kAssumed);
  EXPECT_FALSE(world.warning.empty());
  EXPECT_TRUE(world.T_world_left.translation().isZero());
  // The camera looks along x, its up is z.
  EXPECT_TRUE(
      (world.T_world_left.linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(
      (world.T_world_left.linear() * -Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
}

TEST(WorldFrameTest, LevelsTheBodyByTheAccelerometerAndKeepsItsYaw) {
  Mounting mounting;
  mounting.T_body_left = PitchedMounting(0.2);
  mounting.T_left_imu = mounting.T_body_left->inverse();
  const Eigen::Matrix3d R_world_body = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() *
                                       Eigen::AngleAxisd(-0.05, Eigen::Vector3d::UnitX()).toRotationMatrix();
  SensorSamples samples;
  samples.imu.push_back(
      {{}, Eigen::Vector3d::Zero(), R_world_body.transpose() * Eigen::Vector3d(0, 0, 9.81)});
  const WorldFrame world = LayWorldFrame({}, mounting, samples);
  EXPECT_EQ(world.gravity.source, GravitySource::kImu);
  const Eigen::Isometry3d T_world_body = world.T_world_left * mounting.T_body_left->inverse();
  EXPECT_TRUE(T_world_body.linear().isApprox(R_world_body, 1e-9));
  EXPECT_TRUE(T_world_body.translation().isZero(1e-12));

  OdometryConfig without;
  without.use_imu = false;
  EXPECT_EQ(LayWorldFrame(without, mounting, samples).gravity.source, GravitySource::kMounting);
}

}  // namespace
}  // namespace terrace
