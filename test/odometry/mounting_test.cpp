// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/mounting.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "odometry/world_frame.h"

namespace terrace {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDegree = M_PI / 180.0;

/// A level body under a camera that looks along x, rolled clockwise.
StereoCalibration RolledCamera(double roll_deg) {
  StereoCalibration calibration;
  Eigen::Isometry3d T_body_camera = Eigen::Isometry3d::Identity();
  T_body_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T_body_camera.linear() =
      Eigen::AngleAxisd(roll_deg * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix() *
      T_body_camera.linear();
  T_body_camera.translation() << 0.3, 0.0, 0.1;
  calibration.T_body_rawleft = T_body_camera;
  return calibration;
}

/// Up of the world in the axes of the raw camera at the first frame.
Eigen::Vector3d UpInCamera(const MountingConfig& config, const StereoCalibration& calibration,
                           const SensorSamples& samples = {}, std::string* warning = nullptr) {
  const Mounting mounting = MountingOf(config, calibration, Eigen::Matrix3d::Identity());
  const WorldFrame world = LayWorldFrame({}, mounting, samples);
  if (warning != nullptr) *warning = world.warning;
  return world.T_world_left.linear().transpose() * Eigen::Vector3d::UnitZ();
}

SensorSamples Attitude(double roll_deg) {
  SensorSamples samples;
  BodyPrior prior;
  prior.kind = PriorKind::kAttitude;
  prior.T_odom_body.linear() =
      Eigen::AngleAxisd(roll_deg * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
  samples.priors.push_back(prior);
  return samples;
}

TEST(MountingTest, BelievesAPortraitCameraWhenToldSo) {
  MountingConfig config;
  config.source = "body";
  std::string warning;
  for (const double roll_deg : {90.0, -90.0, 180.0, 45.0}) {
    const Eigen::Vector3d up = UpInCamera(config, RolledCamera(roll_deg), {}, &warning);
    // Turned clockwise, the camera sees up on its left.
    const Eigen::Vector3d expected(-std::sin(roll_deg * kDegree), -std::cos(roll_deg * kDegree), 0.0);
    EXPECT_LT((up - expected).norm(), 1e-9) << roll_deg;
    EXPECT_THAT(warning, IsEmpty());
  }
}

TEST(MountingTest, DoubtsAPortraitCameraUntilTheRobotFindsItsBodyUpright) {
  std::string warning;
  UpInCamera({}, RolledCamera(90.0), {}, &warning);
  EXPECT_THAT(warning, HasSubstr("camera.mounting.source"));
  const Eigen::Vector3d up = UpInCamera({}, RolledCamera(90.0), Attitude(5.0), &warning);
  EXPECT_THAT(warning, IsEmpty());
  EXPECT_NEAR(std::acos(up.dot(Eigen::Vector3d(-1, 0, 0))) / kDegree, 5.0, 1e-6);
  // An attitude that finds it on its side speaks of a sensor.
  UpInCamera({}, RolledCamera(90.0), Attitude(80.0), &warning);
  EXPECT_THAT(warning, HasSubstr("taken for the axes of a sensor"));
}

TEST(MountingTest, TakesABodyForASensorWhenToldSo) {
  MountingConfig config;
  config.source = "sensor";
  std::string warning;
  const Eigen::Vector3d up = UpInCamera(config, RolledCamera(30.0), {}, &warning);
  EXPECT_TRUE(up.isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_THAT(warning, IsEmpty());
}

TEST(MountingTest, ReplacesTheBodyByConfiguredAnglesAndKeepsTheImuWhereItIs) {
  StereoCalibration calibration = RolledCamera(0.0);
  calibration.T_body_imu = Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.2, 0.3));
  const Mounting before = MountingOf({}, calibration, Eigen::Matrix3d::Identity());
  MountingConfig config;
  config.pitch_deg = 45.0;
  config.position_m = {0.4, 0.0, 0.2};
  ASSERT_THAT(config.Problems(), IsEmpty());
  const Mounting mounting = MountingOf(config, calibration, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(mounting.T_body_left);
  const double half = std::sqrt(0.5);
  EXPECT_TRUE((mounting.T_body_left->linear() * Eigen::Vector3d::UnitZ())
                  .isApprox(Eigen::Vector3d(half, 0, -half), 1e-12));  // looks down
  EXPECT_TRUE(mounting.T_body_left->translation().isApprox(Eigen::Vector3d(0.4, 0, 0.2)));
  EXPECT_TRUE(mounting.T_left_imu->isApprox(*before.T_left_imu, 1e-12));
}

TEST(MountingTest, TakesUpFromTheRawImageWhereThePairIsTurned) {
  // One camera above the other: rectified rows are raw columns.
  Eigen::Matrix3d R_rect_raw;
  R_rect_raw << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  const Mounting mounting = MountingOf({}, StereoCalibration(), R_rect_raw);
  const WorldFrame world = LayWorldFrame({}, mounting, {});
  EXPECT_EQ(world.gravity.source, GravitySource::kAssumed);
  const Eigen::Vector3d up_raw =
      R_rect_raw.transpose() * (world.T_world_left.linear().transpose() * Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(up_raw.isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(MountingTest, SaysWhichSettingCannotBe) {
  MountingConfig config;
  config.source = "floor";
  config.yaw_deg = 270.0;
  config.position_m = {1.0};
  EXPECT_EQ(config.Problems().size(), 3u);
}

}  // namespace
}  // namespace terrace
