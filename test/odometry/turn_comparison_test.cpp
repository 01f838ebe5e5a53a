// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/turn_comparison.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

using Turns = std::function<Eigen::Vector3d(double t_s)>;

/// A gait that sways and a turn, in rad/s.
Eigen::Vector3d Gait(double t_s) {
  return {0.35 * std::cos(8 * t_s), 0.25 + 0.3 * std::cos(6 * t_s), 0.15 * std::cos(4 * t_s)};
}

/// Four seconds, with the noise of both.
std::optional<std::string> SaidOf(const Turns& by_imu, const Turns& by_images) {
  constexpr double kBetween_s = 0.066;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.0008);
  TurnComparison turns;
  for (int i = 0; i < 60; ++i) {
    const double t_s = kBetween_s * i;
    const auto noisy = [&](const Eigen::Vector3d& v) {
      return Eigen::Vector3d(v + Eigen::Vector3d(noise(random), noise(random), noise(random)));
    };
    turns.Hear(noisy(kBetween_s * by_imu(t_s)), noisy(kBetween_s * by_images(t_s)), kBetween_s);
  }
  return turns.Problem();
}

void ExpectSaid(const Turns& by_imu, const std::string& words) {
  const auto said = SaidOf(by_imu, Gait);
  ASSERT_TRUE(said) << words;
  EXPECT_NE(said->find(words), std::string::npos) << *said;
}

TEST(TurnComparisonTest, BelievesTheSameTurnsAndASmallBias) {
  EXPECT_FALSE(SaidOf(Gait, Gait));
  EXPECT_FALSE(SaidOf([](double t) { return Eigen::Vector3d(Gait(t).array() + 0.03); }, Gait));
  EXPECT_FALSE(SaidOf([](double t) { return Gait(t - 0.01); }, Gait)) << "a clock a little late";
}

TEST(TurnComparisonTest, NamesUnitAndSign) {
  ExpectSaid([](double t) { return Eigen::Vector3d(180.0 / M_PI * Gait(t)); }, "degrees per second");
  ExpectSaid([](double t) { return Eigen::Vector3d(-Gait(t)); }, "sign");
}

TEST(TurnComparisonTest, DoubtsAxesClockAndBias) {
  ExpectSaid([](double t) { return Eigen::Vector3d(Gait(t).y(), Gait(t).x(), Gait(t).z()); }, "axes");
  ExpectSaid([](double t) { return Gait(t - 0.15); }, "clock");
  ExpectSaid([](double t) { return Eigen::Vector3d(Gait(t).array() + 0.3); }, "bias");
}

TEST(TurnComparisonTest, SaysNothingOfAStandingRobot) {
  const Turns rest = [](double) { return Eigen::Vector3d::Zero(); };
  EXPECT_FALSE(SaidOf(rest, rest));
}

TEST(TurnComparisonTest, IsNotMisledByOneImageThatWasMisread) {
  EXPECT_FALSE(SaidOf(
      Gait, [](double t) { return std::abs(t - 2.0) < 0.03 ? Eigen::Vector3d(3.0, 0.0, 0.0) : Gait(t); }));
}

}  // namespace
}  // namespace terrace
