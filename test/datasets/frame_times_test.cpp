// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/frame_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<Timestamp> FramesAt(std::vector<double> times_s) {
  std::vector<Timestamp> times;
  for (const double t_s : times_s) times.push_back({static_cast<std::int64_t>(t_s * 1e9)});
  return times;
}

struct FrameRow {
  Timestamp t;
};

TEST(FrameTimesTest, FindsWhereAClockWasSetBack) {
  EXPECT_THAT(ClockBreaks(FramesAt({5000, 5001, 5002, 100, 101, 102, 50, 51})), ElementsAre(3, 6));
}

TEST(FrameTimesTest, TakesASingleWildTimeForNoNewClock) {
  EXPECT_THAT(ClockBreaks(FramesAt({100, 101, 1e6, 102, 103, 5, 104, 105})), IsEmpty());
}

TEST(FrameTimesTest, TakesMessagesThatOvertakeOneAnotherForNoNewClock) {
  EXPECT_THAT(ClockBreaks(FramesAt({100, 100.1, 100.3, 100.2, 100.25, 100.4})), IsEmpty());
}

TEST(FrameTimesTest, CountsEverySensorOnAfterAGap) {
  std::vector<FrameRow> frames, samples;
  for (const double t : {5000.0, 5001.0, 100.0, 101.0}) frames.push_back({FramesAt({t})[0]});
  for (const double t : {5000.0, 5000.5, 5001.0, 100.2, 100.4}) samples.push_back({FramesAt({t})[0]});
  const auto offsets = OffsetsThatCountOn(FramesAt({5000, 5001, 100, 101}));
  ASSERT_EQ(offsets.size(), 1u);
  CountOn(offsets, &frames);
  CountOn(offsets, &samples);
  EXPECT_NEAR(frames[2].t.seconds(), 5011.0, 1e-6);
  EXPECT_NEAR(samples[3].t.seconds(), 5011.2, 1e-6);
  EXPECT_THAT(*SentenceAbout(offsets), HasSubstr("set back 1 time, first at row 3"));
}

TEST(FrameTimesTest, NamesTheFactorOfTimesInAnotherUnit) {
  EXPECT_FALSE(StrangeRate(FramesAt({0, 0.1, 0.2, 0.3, 0.4})));
  EXPECT_THAT(*StrangeRate({{0}, {66'667}, {133'333}, {200'000}}), HasSubstr("factor 1000 "));
  EXPECT_THAT(*StrangeRate({{0}, {67}, {133}, {200}}), HasSubstr("factor 1e+06"));
  EXPECT_THAT(*StrangeRate(FramesAt({0, 66, 133, 200})), HasSubstr("factor 0.001"));
}

}  // namespace
}  // namespace terrace
