// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/stamp_pace.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

constexpr double kPeriod_s = 1.0 / 15.0;

/// What is said at the end of messages that come fifteen times a second.
double FactorOf(double stamp_seconds_a_second, int num_messages, int clock_set_at = -1) {
  StampPace pace;
  double factor = 1.0;
  double stamp_s = 1000.0;
  for (int i = 0; i < num_messages; ++i) {
    if (i == clock_set_at) stamp_s += 3600.0;
    stamp_s += kPeriod_s * stamp_seconds_a_second;
    const auto arrived =
        StampPace::ArrivalTime() + std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * kPeriod_s * i));
    factor = pace.Add(Timestamp{static_cast<std::int64_t>(1e9 * stamp_s)}, arrived);
  }
  return factor;
}

TEST(StampPaceTest, NamesTheFactorOfStampsInAnotherUnitWithinTwoSeconds) {
  EXPECT_DOUBLE_EQ(FactorOf(1e-3, 30), 1e3) << "milliseconds for microseconds";
  EXPECT_DOUBLE_EQ(FactorOf(1e-6, 30), 1e6) << "seconds for microseconds";
  EXPECT_DOUBLE_EQ(FactorOf(1e3, 30), 1e-3) << "nanoseconds for microseconds";
  EXPECT_EQ(SentenceAboutPace(1e-3),
            "its time stamps go 1000 times too fast: they are in another unit; with the "
            "factor 0.001 they would be right");
}

TEST(StampPaceTest, LetsPlayersGoFasterOrSlowerAndClocksBeSet) {
  EXPECT_DOUBLE_EQ(FactorOf(1.0, 60), 1.0);
  EXPECT_DOUBLE_EQ(FactorOf(0.02, 60), 1.0);
  EXPECT_DOUBLE_EQ(FactorOf(50.0, 60), 1.0);
  EXPECT_DOUBLE_EQ(FactorOf(1.0, 17, 9), 1.0) << "an hour within one second goes 3600 times too fast";
  EXPECT_DOUBLE_EQ(FactorOf(1e-3, 10), 1.0) << "not known yet";
}

TEST(StampPaceTest, BelievesStampsAgainOnceTheyGoAsTheClockDoes) {
  StampPace pace;
  double factor = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double stamp_s = i < 30 ? 1e-3 * i * kPeriod_s : 1000.0 + i * kPeriod_s;
    factor = pace.Add(
        Timestamp{static_cast<std::int64_t>(1e9 * stamp_s)},
        StampPace::ArrivalTime() + std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * i * kPeriod_s)));
    if (i == 29) {
      EXPECT_DOUBLE_EQ(factor, 1e3);
    }
  }
  EXPECT_DOUBLE_EQ(factor, 1.0);
}

}  // namespace
}  // namespace terrace
