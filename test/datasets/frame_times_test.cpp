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

TEST(FrameTimesTest, SaysThatAnImuIsOfAnotherClock) {
  const std::vector<Timestamp> images = FramesAt({1000, 1001, 1002});
  const auto sentence = [&](double from_s) {
    std::vector<ImuSample> samples;
    for (const Timestamp t : FramesAt({from_s, from_s + 0.5, from_s + 1.0})) samples.push_back({t, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
    return OtherClockOfImu(images, samples);
  };
  EXPECT_FALSE(sentence(1000.2));
  EXPECT_FALSE(sentence(999.5)) << "it has begun earlier";
  EXPECT_FALSE(OtherClockOfImu(images, {})) << "there is none";
  EXPECT_THAT(*sentence(1010.0),
              HasSubstr("of 1010.000 to 1011.000 s, the images are of 1000.000 to 1002.000 s"));
  EXPECT_TRUE(sentence(7.0)) << "since the start of the machine";
}

}  // namespace
}  // namespace terrace
