// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/sensors.h"

#include <cmath>

#include <gtest/gtest.h>

namespace terrace::synthetic {
namespace {

Radiance Uniform(float value) { return {100, 80, std::vector<float>(100 * 80, value)}; }

TEST(ImageSensorTest, NoiseGrowsWithTheLightAsPhotonsDo) {
  Photometry photometry;
  photometry.vignette = 0.0;
  const ImageSensor sensor(photometry);
  const auto statistics = [&](float light) {
    const GrayImage image = sensor.Expose(Uniform(light), 1.0, 9);
    double sum = 0.0;
    double squares = 0.0;
    for (const std::uint8_t value : image.data) {
      // Back to linear light.
      const double s = (value - photometry.black) / (255.0 - photometry.black);
      const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
      sum += linear;
      squares += linear * linear;
    }
    const double n = static_cast<double>(image.data.size());
    return std::pair(sum / n, std::sqrt(squares / n - sum / n * (sum / n)));
  };
  for (const float light : {0.2F, 0.6F}) {
    const auto [mean, sigma] = statistics(light);
    EXPECT_NEAR(mean, light, 0.01 * light);
    const double expected = std::sqrt(light * photometry.full_well + 100.0) / photometry.full_well;
    // Rounding to grey values adds a little.
    EXPECT_NEAR(sigma, expected, 0.25 * expected);
  }
}

TEST(ImageSensorTest, CornersAreDarkerAndTheSameSeedGivesTheSameBytes) {
  const ImageSensor sensor({});
  const GrayImage image = sensor.Expose(Uniform(0.3F), 1.0, 3);
  EXPECT_LT(image.data[0], image.data[40 * 100 + 50] - 10);
  EXPECT_EQ(image.data, sensor.Expose(Uniform(0.3F), 1.0, 3).data);
  EXPECT_NE(image.data, sensor.Expose(Uniform(0.3F), 1.0, 4).data);
}

TEST(AutoExposureTest, ReturnsToTheTargetAfterTheLightChanges) {
  AutoExposure exposure(0.17, 1.25, 15.0);
  EXPECT_NEAR(exposure.GainFor(0.34) * 0.34, 0.17, 1e-9);
  EXPECT_NEAR(exposure.GainFor(0.085) * 0.085, 0.0425, 1e-3);  // surprised
  double brightness = 0.0;
  for (int i = 0; i < 75; ++i) brightness = exposure.GainFor(0.085) * 0.085;
  EXPECT_NEAR(brightness, 0.17, 0.01);
}

class RobotSensorsTest : public testing::Test {
 protected:
  RobotSensorsTest() {
    MotionPlan plan;
    plan.path = {{0.0, 0.0}, {2.0, 0.0}, {3.0, 2.0}};
    plan.heading_rad = 0.4;
    trajectory_ = std::make_unique<Trajectory>(PlanMotion(
        plan, Mounting(), [](const Eigen::Vector3d&) { return 0.0; }, 2));
  }
  std::unique_ptr<Trajectory> trajectory_;
};

TEST_F(RobotSensorsTest, TheImuAtRestFeelsGravityAndItsBias) {
  const std::vector<ImuRecord> records =
      SimulateImu(*trajectory_, {1.7e-4, 2e-5, 2e-3, 3e-3}, 200.0, {1000}, 5);
  ASSERT_GT(records.size(), 1000u);
  EXPECT_EQ(records[1].sample.t.ns - records[0].sample.t.ns, 5'000'000);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < 80; ++i)
    mean += (records[i].sample.accel - records[i].accel_bias) / 80.0;  // standing still
  EXPECT_NEAR(mean.norm(), 9.81, 0.03);
}

TEST_F(RobotSensorsTest, TheAttitudeFilterIsGoodToADegreeAndDriftsInYaw) {
  for (const PriorRecord& record : SimulateAttitude(*trajectory_, 100.0, {0}, 6)) {
    const Eigen::Matrix3d truth = trajectory_->PoseAt(record.t.seconds()).rotation();
    const Eigen::Vector3d up_true = truth.transpose().col(2);
    const Eigen::Vector3d up = record.T_odom_body.linear().transpose().col(2);
    EXPECT_LT(std::acos(std::min(up.dot(up_true), 1.0)), 0.04);
    EXPECT_EQ(record.T_odom_body.translation().norm(), 0.0);
  }
}

TEST_F(RobotSensorsTest, LegsGoThreePercentTooFarAndSlip) {
  const std::vector<PriorRecord> legs = SimulateLegs(*trajectory_, 50.0, {0}, 7);
  EXPECT_LT(legs.front().T_odom_body.translation().norm(), 1e-9);
  double way = 0.0;
  double true_way = 0.0;
  for (std::size_t i = 50; i < legs.size(); i += 50) {
    way += (legs[i].T_odom_body.translation() - legs[i - 50].T_odom_body.translation()).norm();
    true_way += (trajectory_->PoseAt(legs[i].t.seconds()).translation() -
                 trajectory_->PoseAt(legs[i - 50].t.seconds()).translation())
                    .norm();
  }
  EXPECT_NEAR(way / true_way, 1.03, 0.03);
  EXPECT_GT(legs.back().translation_sigma_m.x(), legs[10].translation_sigma_m.x());
}

}  // namespace
}  // namespace terrace::synthetic
