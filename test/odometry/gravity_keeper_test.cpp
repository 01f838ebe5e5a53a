// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/gravity_keeper.h"

#include <cmath>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// A body in the camera's place and axes, so that one rotation is another.
Mounting CameraIsBody() {
  Mounting mounting;
  mounting.T_body_left = Eigen::Isometry3d::Identity();
  return mounting;
}

Gravity Down(const Eigen::Vector3d& down, double sigma_rad, GravitySource source) {
  return {down.normalized(), sigma_rad, source};
}

SensorSamples AttitudeLeaning(double roll_rad) {
  BodyPrior prior;
  prior.kind = PriorKind::kAttitude;
  prior.T_odom_body.linear() = Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()).toRotationMatrix();
  prior.covariance.diagonal().setConstant(0.01 * 0.01);
  SensorSamples samples;
  samples.priors.push_back(prior);
  return samples;
}

TEST(GravityKeeperTest, FallsBackToWhatWasKnownWithoutAnImuThatIsRefused) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity mounting = Down(-Eigen::Vector3d::UnitZ(), 0.035, GravitySource::kMounting);
  keeper.Start(Down({0.2, 0.0, -1.0}, 0.05, GravitySource::kImu), mounting);
  keeper.Refine(Eigen::Vector3d::UnitZ(), 0.001);
  keeper.RefuseImu();
  EXPECT_EQ(keeper.gravity().source, GravitySource::kMounting);
  EXPECT_TRUE(keeper.gravity().down_world.isApprox(mounting.down_world));
  EXPECT_EQ(keeper.gravity().sigma_rad, mounting.sigma_rad);
}

TEST(GravityKeeperTest, TakesPlanesOnlyWhereTheyKnowBetter) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity mounting = Down(-Eigen::Vector3d::UnitZ(), 0.035, GravitySource::kMounting);
  keeper.Start(mounting, mounting);
  GravityHint vague;
  vague.down_world = Eigen::Vector3d(0.1, 0.0, -1.0).normalized();
  vague.sigma_rad = 0.04;
  keeper.Take(vague);
  EXPECT_EQ(keeper.gravity().source, GravitySource::kMounting);
  GravityHint sharp = vague;
  sharp.sigma_rad = 0.01;
  keeper.Take(sharp);
  EXPECT_EQ(keeper.gravity().source, GravitySource::kPlane);
  keeper.UseImu();
  sharp.down_world = -Eigen::Vector3d::UnitZ();
  sharp.sigma_rad = 0.001;
  keeper.Take(sharp);
  EXPECT_TRUE(keeper.gravity().down_world.isApprox(vague.down_world)) << "an IMU knows better";
}

TEST(GravityKeeperTest, AveragesTheAttitudeOfALeaningBody) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity mounting = Down(-Eigen::Vector3d::UnitZ(), 0.035, GravitySource::kMounting);
  keeper.Start(mounting, mounting);
  const PoseEstimate pose;
  for (int i = 0; i < 50; ++i) keeper.FollowAttitude(AttitudeLeaning(i % 2 ? 0.21 : 0.19), pose);
  EXPECT_EQ(keeper.gravity().source, GravitySource::kAttitude);
  const Eigen::Vector3d truth(0.0, -std::sin(0.2), -std::cos(0.2));
  EXPECT_LT(std::acos(keeper.gravity().down_world.dot(truth)), 0.004);
  EXPECT_LT(keeper.gravity().sigma_rad, 0.01);
}

TEST(GravityKeeperTest, RefusesAnAttitudeThatTurnsWhileTheImagesShowThatNothingDoes) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity mounting = Down(-Eigen::Vector3d::UnitZ(), 0.035, GravitySource::kMounting);
  keeper.Start(mounting, mounting);
  const PoseEstimate pose;
  for (int i = 0; i < 20; ++i) keeper.FollowAttitude(AttitudeLeaning(0.01), pose);
  EXPECT_FALSE(keeper.TakeWarning());
  for (int i = 0; i < 20; ++i) keeper.FollowAttitude(AttitudeLeaning(0.36), pose);
  const Eigen::Vector3d truth(0.0, -std::sin(0.01), -std::cos(0.01));
  EXPECT_LT(std::acos(keeper.gravity().down_world.dot(truth)), 0.005);
  const auto warning = keeper.TakeWarning();
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("body attitude is 20 deg"), std::string::npos) << *warning;
}

TEST(GravityKeeperTest, BelievesARefusedAttitudeAgainOnceItAgrees) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity mounting = Down(-Eigen::Vector3d::UnitZ(), 0.035, GravitySource::kMounting);
  keeper.Start(mounting, mounting);
  const PoseEstimate pose;
  for (int i = 0; i < 20; ++i) keeper.FollowAttitude(AttitudeLeaning(0.01), pose);
  for (int i = 0; i < 20; ++i) keeper.FollowAttitude(AttitudeLeaning(0.36), pose);
  ASSERT_TRUE(keeper.TakeWarning());
  for (int i = 0; i < 40; ++i) keeper.FollowAttitude(AttitudeLeaning(0.01), pose);
  const auto warning = keeper.TakeWarning();
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("agrees with the images again"), std::string::npos) << *warning;
  const GravityHint floor{0, -Eigen::Vector3d::UnitZ(), 1e-4};
  keeper.Take(floor);
  EXPECT_EQ(keeper.gravity().source, GravitySource::kAttitude) << "it knows better than floors again";
}

TEST(GravityKeeperTest, TakesRollAndPitchOfTheLegsWhereNothingIsBetter) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity mounting = Down(-Eigen::Vector3d::UnitZ(), 0.035, GravitySource::kMounting);
  keeper.Start(mounting, mounting);
  SensorSamples legs = AttitudeLeaning(0.4);
  legs.priors[0].kind = PriorKind::kLegOdometry;
  keeper.FollowAttitude(legs, PoseEstimate());
  const Eigen::Vector3d truth(0.0, -std::sin(0.4), -std::cos(0.4));
  EXPECT_LT(std::acos(keeper.gravity().down_world.dot(truth)), 0.01);
}

SensorSamples AttitudeAndLegs(double attitude_roll_rad, double legs_roll_rad) {
  SensorSamples both = AttitudeLeaning(attitude_roll_rad);
  both.priors.push_back(AttitudeLeaning(legs_roll_rad).priors[0]);
  both.priors[1].kind = PriorKind::kLegOdometry;
  return both;
}

TEST(GravityKeeperTest, RefusesAnAttitudeThatIsOffFromTheStartWhereTheLegsSayThatTheRobotStoodLevel) {
  GravityKeeper keeper({}, CameraIsBody());
  // The world was laid by that attitude: if the body stood level, down is not where the world has it.
  const Eigen::Vector3d truth(0.0, -std::sin(0.01), -std::cos(0.01));
  const Gravity attitude = Down({0.0, -std::sin(0.36), -std::cos(0.36)}, 0.002, GravitySource::kAttitude);
  keeper.Start(attitude, attitude, -Eigen::Vector3d::UnitZ());
  for (int i = 0; i < 20; ++i) keeper.FollowAttitude(AttitudeAndLegs(0.36, 0.01), PoseEstimate());
  EXPECT_LT(std::acos(keeper.gravity().down_world.dot(truth)), 3.0 * keeper.gravity().sigma_rad);
  const auto warning = keeper.TakeWarning();
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("body attitude leans 20 deg"), std::string::npos) << *warning;
  // It has a way back.
  for (int i = 0; i < 40; ++i) keeper.FollowAttitude(AttitudeAndLegs(0.01, 0.01), PoseEstimate());
  EXPECT_LT(std::acos(keeper.gravity().down_world.dot(truth)), 3.0 * keeper.gravity().sigma_rad);
  EXPECT_LT(keeper.gravity().sigma_rad, 0.0175) << "the attitude's again";
}

TEST(GravityKeeperTest, KeepsTheAttitudeWhereItIsTheLegsThatLean) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity attitude = Down(-Eigen::Vector3d::UnitZ(), 0.002, GravitySource::kAttitude);
  keeper.Start(attitude, attitude, -Eigen::Vector3d::UnitZ());
  for (int i = 0; i < 40; ++i) keeper.FollowAttitude(AttitudeAndLegs(0.01, 0.36), PoseEstimate());
  const Eigen::Vector3d truth(0.0, -std::sin(0.01), -std::cos(0.01));
  EXPECT_LT(std::acos(keeper.gravity().down_world.dot(truth)), 0.005);
  const auto warning = keeper.TakeWarning();
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("legs' are not used"), std::string::npos) << *warning;
}

TEST(GravityKeeperTest, BelievesARobotThatIsStartedOnASlopeAsLongAsItsSensorsAgree) {
  GravityKeeper keeper({}, CameraIsBody());
  const Gravity attitude = Down({0.0, -std::sin(0.36), -std::cos(0.36)}, 0.002, GravitySource::kAttitude);
  keeper.Start(attitude, attitude, -Eigen::Vector3d::UnitZ());
  for (int i = 0; i < 40; ++i) keeper.FollowAttitude(AttitudeAndLegs(0.36, 0.35), PoseEstimate());
  EXPECT_TRUE(keeper.gravity().down_world.isApprox(attitude.down_world, 0.005));
  EXPECT_FALSE(keeper.TakeWarning());
}

}  // namespace
}  // namespace terrace
