// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/motion_model.h"

#include <cmath>

#include <gtest/gtest.h>

#include "odometry/bridging.h"
#include "odometry/credible.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

constexpr double kFrameTime_s = 0.05;

Timestamp At(double t_s) { return Timestamp{std::llround(t_s * 1e9)}; }

/// An IMU in the camera that turns steadily about z and falls freely: it measures no acceleration.
SensorSamples TurningUpTo(double t_s, double rate) {
  SensorSamples samples;
  constexpr int kSamples = 10;
  for (int k = 1; k <= kSamples; ++k) {
    ImuSample sample;
    sample.t = At(t_s - kFrameTime_s + k * kFrameTime_s / kSamples);
    sample.gyro.z() = rate;
    samples.imu.push_back(sample);
  }
  return samples;
}

PoseEstimate PoseAt(double t_s) {
  PoseEstimate pose;
  pose.t_capture = At(t_s);
  pose.status = TrackingStatus::kTracking;
  return pose;
}

TEST(MotionModelTest, BridgesForThousandsOfFramesWithoutWearingOutTheRotation) {
  Mounting mounting;
  mounting.T_left_imu = Eigen::Isometry3d::Identity();
  mounting.T_left_imu->linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  MotionModel motion({}, mounting);
  Bridging bridging;
  PoseEstimate last = PoseAt(0.0);
  bridging.See(last);
  const Gravity gravity;
  motion.Read(TurningUpTo(0.0, 0.5), std::nullopt, At(0.0), {});
  motion.UseImu();
  for (int i = 1; i < 3000; ++i) {
    const double t_s = i * kFrameTime_s;
    motion.Read(TurningUpTo(t_s, 0.5), last, At(t_s), {});
    const Motion predicted = motion.Predict(last, At(t_s), {}, gravity);
    last = bridging.Extend(last, predicted, [](double) { return Matrix6d::Identity(); });
    last.t_capture = At(t_s);
    motion.Bridge(predicted, gravity);
    ASSERT_TRUE(IsPose(last.T_world_left)) << "frame " << i;
  }
  const double turned = 0.5 * kFrameTime_s * 2999;
  EXPECT_NEAR(LogRotation(last.T_world_left.linear()).norm(), std::abs(std::remainder(turned, 2 * M_PI)),
              1e-3);
}

TEST(MotionModelTest, GoesOnAsItMovedWithoutAnySensor) {
  MotionModel motion({}, {});
  PoseEstimate last = PoseAt(0.0);
  const Gravity gravity;
  for (int i = 1; i <= 40; ++i) {
    const double t_s = i * kFrameTime_s;
    const Motion predicted = motion.Predict(last, At(t_s), {}, gravity);
    PoseEstimate pose = PoseAt(t_s);
    pose.T_world_left.translation().x() = 0.5 * t_s;
    pose.T_prev_left = last.T_world_left.inverse() * pose.T_world_left;
    motion.Correct(last, pose, predicted, {}, gravity);
    last = pose;
  }
  const Motion predicted = motion.Predict(last, At(41 * kFrameTime_s), {}, gravity);
  EXPECT_NEAR(predicted.T_last_left.translation().x(), 0.5 * kFrameTime_s, 1e-3);
  motion.Lose();
  const Motion lost = motion.Predict(last, At(41 * kFrameTime_s), {}, gravity);
  EXPECT_TRUE(lost.T_last_left.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(MotionModelTest, TakesTheStepOfTheLegsAndNotTheirPose) {
  Mounting mounting;
  mounting.T_body_left = Eigen::Isometry3d(Eigen::Translation3d(0.2, 0.0, 0.1));
  MotionModel motion({}, mounting);
  BodyPrior prior;
  prior.T_odom_body = Eigen::Isometry3d(Eigen::Translation3d(7.0, -3.0, 0.0));
  motion.Read({{}, {prior}}, std::nullopt, At(0.0), {});
  prior.T_odom_body = prior.T_odom_body * Eigen::Translation3d(0.03, 0.0, 0.0);
  motion.Read({{}, {prior}}, PoseAt(0.0), At(kFrameTime_s), {});
  const Motion predicted = motion.Predict(PoseAt(0.0), At(kFrameTime_s), {}, {});
  EXPECT_TRUE(predicted.by_legs);
  EXPECT_LT((predicted.T_last_left.translation() - Eigen::Vector3d(0.03, 0, 0)).norm(), 1e-9);
}

TEST(CredibleTest, LeavesOutOnlyWhatNoSensorCanHaveMeasured) {
  SensorSamples samples = TurningUpTo(1.0, 30.0);
  samples.imu[2].accel.x() = 150.0;  // a foot strike at the end of the range
  samples.imu[3].accel.x() = 1e6;
  samples.imu[4].gyro.z() = std::nan("");
  BodyPrior bent;
  bent.T_odom_body.linear() *= 2.0;
  samples.priors = {BodyPrior(), bent};
  int num_dropped = 0;
  const SensorSamples credible = Credible(samples, &num_dropped);
  EXPECT_EQ(num_dropped, 3);
  EXPECT_EQ(credible.imu.size(), samples.imu.size() - 2);
  EXPECT_EQ(credible.priors.size(), 1u);
}

}  // namespace
}  // namespace terrace
