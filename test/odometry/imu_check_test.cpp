// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_check.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// A walk of a second, 200 samples, frames at 20 Hz: what the check says of it.
std::optional<std::string> VerdictOf(const std::function<void(ImuSample&)>& fault) {
  ImuCheck check(Eigen::Vector3d::UnitZ());
  std::optional<std::string> verdict;
  for (int frame = 0; frame < 20; ++frame) {
    std::vector<ImuSample> samples;
    for (int k = 1; k <= 10; ++k) {
      ImuSample sample;
      const double t_s = 0.05 * frame + 0.005 * k;
      sample.t = Timestamp{1'000'000'000'000 + std::llround(t_s * 1e9)};
      sample.gyro << 0.3 * std::sin(9 * t_s), 0.2, 0.4 * std::cos(7 * t_s);
      sample.accel << 2 * std::sin(12 * t_s), 1.0, 9.81 + 5 * std::sin(25 * t_s);
      fault(sample);
      samples.push_back(sample);
    }
    const auto said = check.Read(samples, Timestamp{1'000'000'000'000 + (frame + 1) * 50'000'000ll});
    EXPECT_FALSE(said && verdict) << "said twice";
    if (said) verdict = said;
  }
  return verdict;
}

void ExpectNamed(const std::function<void(ImuSample&)>& fault, const std::string& word) {
  const auto verdict = VerdictOf(fault);
  ASSERT_TRUE(verdict) << word;
  EXPECT_NE(verdict->find(word), std::string::npos) << *verdict;
}

TEST(ImuCheckTest, BelievesAWalk) {
  EXPECT_FALSE(VerdictOf([](ImuSample&) {}));
  EXPECT_FALSE(VerdictOf([](ImuSample& sample) { sample.accel.x() += 0.5; }));
}

TEST(ImuCheckTest, NamesTheSuspectedUnitSignOrClock) {
  ExpectNamed([](ImuSample& sample) { sample.accel /= 9.81; }, "in g");
  ExpectNamed([](ImuSample& sample) { sample.accel *= -1.0; }, "sign");
  ExpectNamed([](ImuSample& sample) { sample.accel.setZero(); }, "nothing");
  ExpectNamed([](ImuSample& sample) { sample.gyro *= 180.0 / M_PI; }, "degrees per second");
  ExpectNamed([](ImuSample& sample) { sample.t.ns -= 999'000'000'000; }, "clock");
  ExpectNamed([](ImuSample& sample) { sample.t.ns /= 1'000'000; }, "clock");
}

TEST(ImuCheckTest, JudgesNothingByAFewSamples) {
  ImuCheck check(Eigen::Vector3d::UnitZ());
  ImuSample falling;
  falling.t = Timestamp{1'000'000'000};
  EXPECT_FALSE(check.Read(std::vector<ImuSample>(10, falling), falling.t));
}

}  // namespace
}  // namespace terrace
