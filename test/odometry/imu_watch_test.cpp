// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_watch.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

constexpr std::int64_t kWatchStart_ns = 1'000'000'000'000;
constexpr std::int64_t kWatchStep_ns = 5'000'000;

/// So many samples of a walk that begin at a sample, with noise.
std::vector<ImuSample> WalkingSamples(int begin, int count, const std::function<void(ImuSample&)>& fault) {
  std::mt19937 random(static_cast<std::uint32_t>(begin) + 1);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::vector<ImuSample> samples;
  for (int i = begin; i < begin + count; ++i) {
    const double t_s = 0.005 * i;
    ImuSample sample;
    sample.t = Timestamp{kWatchStart_ns + i * kWatchStep_ns};
    sample.gyro << 0.8 * std::sin(9 * t_s) + noise(random), 0.2 + noise(random), noise(random);
    sample.accel << 2 * std::sin(12 * t_s) + noise(random), 1.0 + noise(random),
        9.81 + 4 * std::sin(25 * t_s) + noise(random);
    fault(sample);
    samples.push_back(sample);
  }
  return samples;
}

std::optional<std::string> SaidOfAWalk(const std::function<void(ImuSample&)>& fault) {
  ImuWatch watch;
  for (int begin = 0; begin < 600; begin += 13)
    if (const auto said = watch.Read(WalkingSamples(begin, 13, fault))) return said;
  return std::nullopt;
}

TEST(ImuWatchTest, FindsNothingWrongWithAWalk) {
  EXPECT_FALSE(SaidOfAWalk([](ImuSample&) {}));
}

TEST(ImuWatchTest, NamesTheSensorThatCannotShowMore) {
  const auto accel = SaidOfAWalk([](ImuSample& s) { s.accel = s.accel.cwiseMin(9.0); });
  ASSERT_TRUE(accel);
  EXPECT_NE(accel->find("accelerometer"), std::string::npos) << *accel;
  EXPECT_NE(accel->find("no more than 9.0"), std::string::npos) << *accel;
  const auto gyro = SaidOfAWalk([](ImuSample& s) { s.gyro = s.gyro.cwiseMax(-0.5); });
  ASSERT_TRUE(gyro);
  EXPECT_NE(gyro->find("gyroscope"), std::string::npos) << *gyro;
}

TEST(ImuWatchTest, TakesCoarseStepsAtRestForNoClipping) {
  std::mt19937 random(7);
  EXPECT_FALSE(SaidOfAWalk([&](ImuSample& s) {
    s.gyro = 0.01 * Eigen::Vector3d(random() % 2, random() % 2, random() % 2);
    s.accel = Eigen::Vector3d(0.0, 0.05 * (random() % 2), 9.8);
  }));
}

TEST(ImuWatchTest, SeesThatReadingsStandStill) {
  ImuWatch watch;
  watch.Read(WalkingSamples(0, 40, [](ImuSample&) {}));
  EXPECT_FALSE(watch.stands());
  const auto frozen = [](ImuSample& s) { s.gyro.setConstant(0.1), s.accel.setConstant(4.0); };
  watch.Read(WalkingSamples(40, 15, frozen));
  EXPECT_FALSE(watch.stands()) << "drivers repeat a few";
  watch.Read(WalkingSamples(55, 15, frozen));
  EXPECT_TRUE(watch.stands());
  watch.Read(WalkingSamples(70, 1, [](ImuSample&) {}));
  EXPECT_FALSE(watch.stands());
}

TEST(ImuWatchTest, TellsOnceEachTimeThatNothingComesAnyMore) {
  ImuWatch watch;
  const auto at = [](int i) { return Timestamp{kWatchStart_ns + i * kWatchStep_ns}; };
  EXPECT_FALSE(watch.HasFallenSilent(at(900))) << "there has never been one";
  for (const int begin : {0, 400}) {
    watch.Read(WalkingSamples(begin, 10, [](ImuSample&) {}));
    EXPECT_FALSE(watch.HasFallenSilent(at(begin + 30)));
    EXPECT_TRUE(watch.HasFallenSilent(at(begin + 150)));
    EXPECT_FALSE(watch.HasFallenSilent(at(begin + 200)));
  }
}

}  // namespace
}  // namespace terrace
