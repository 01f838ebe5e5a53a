// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/frame_assembler.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kMs = 1'000'000;
const FrameAssembler::ArrivalTime kStart{};

ImuSample Imu(std::int64_t ms) { return {{ms * kMs}, {}, {}}; }
StereoPair Pair(std::int64_t ms) { return {{ms * kMs}, {}, {}, ""}; }
BodyPrior Prior(std::int64_t ms, PriorKind kind) {
  return {{ms * kMs}, kind, Eigen::Isometry3d::Identity(), Matrix6d::Zero()};
}

TEST(FrameAssemblerTest, HandsAFrameOverAtOnceWhenThereIsNoImu) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Pair(1000), kStart);
  const auto frame = assembler.TakeReady(kStart);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pair.t_capture.ns, 1000 * kMs);
  EXPECT_TRUE(frame->samples.imu.empty());
  EXPECT_EQ(assembler.num_imu_gaps(), 0);
}

TEST(FrameAssemblerTest, WaitsForImuSamplesThatArriveAfterTheirImages) {
  FrameAssembler assembler{LiveConfig()};
  for (int ms = 980; ms <= 990; ms += 5) assembler.Add(Imu(ms), kStart);
  assembler.Add(Pair(1000), kStart);
  EXPECT_FALSE(assembler.TakeReady(kStart + milliseconds(5)));
  for (int ms = 995; ms <= 1005; ms += 5) assembler.Add(Imu(ms), kStart + milliseconds(10));
  const auto frame = assembler.TakeReady(kStart + milliseconds(10));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->samples.imu.size(), 5u) << "980 to 1000, its own time included";
  EXPECT_EQ(assembler.num_imu_gaps(), 0);
}

TEST(FrameAssemblerTest, DoesNotWaitForEverAndCountsTheGap) {
  LiveConfig config;
  config.imu_wait_ms = 40.0;
  FrameAssembler assembler(config);
  assembler.Add(Imu(990), kStart);
  assembler.Add(Pair(1000), kStart);
  EXPECT_FALSE(assembler.TakeReady(kStart + milliseconds(39)));
  EXPECT_TRUE(assembler.TakeReady(kStart + milliseconds(40)));
  EXPECT_EQ(assembler.num_imu_gaps(), 1);
}

TEST(FrameAssemblerTest, SaysByHowMuchTheClockOfTheImuIsAnotherOne) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Imu(990), kStart);
  assembler.Add(Pair(1000), kStart);
  EXPECT_FALSE(assembler.imu_clock_ahead());
  for (const int ahead_ms : {10'000, 3'600'000, -5'000}) {
    FrameAssembler other{LiveConfig()};
    other.Add(Pair(60'000), kStart);
    other.TakeAny();
    other.Add(Imu(60'000 + ahead_ms), kStart);  // whether it is taken does not matter
    other.Add(Pair(60'001), kStart);
    ASSERT_TRUE(other.imu_clock_ahead()) << ahead_ms;
    EXPECT_EQ(other.imu_clock_ahead()->count(), (ahead_ms - 1) * kMs);
  }
  assembler.Add(Imu(70'000), kStart);
  assembler.Add(Pair(60'000), kStart + milliseconds(600));
  EXPECT_FALSE(assembler.imu_clock_ahead()) << "that it is silent is another matter";
  assembler.Add(Imu(61'500), kStart + milliseconds(700));
  assembler.Add(Pair(60'100), kStart + milliseconds(700));
  EXPECT_FALSE(assembler.imu_clock_ahead()) << "images may be late";
}

TEST(FrameAssemblerTest, TakesAGapForSilenceWhereTheArrivalShowsItToo) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Pair(1000), kStart);
  assembler.TakeAny();
  assembler.Add(Pair(31'000), kStart + milliseconds(30'000));
  EXPECT_TRUE(assembler.TakeAny()) << "the camera was silent for half a minute";
  EXPECT_EQ(assembler.TakeClockChange().count(), 0);
  EXPECT_EQ(assembler.num_time_jumps(), 0);
  assembler.Add(Pair(61'000), kStart + milliseconds(30'100));
  EXPECT_FALSE(assembler.TakeAny()) << "its clock may have been set";
  EXPECT_EQ(assembler.num_time_jumps(), 1);
}

TEST(FrameAssemblerTest, GivesUpOnAnImuThatHasGoneSilent) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Imu(990), kStart);
  assembler.Add(Pair(2000), kStart + milliseconds(1000));
  EXPECT_TRUE(assembler.TakeReady(kStart + milliseconds(1000)));
}

TEST(FrameAssemblerTest, LeavesOutSamplesOfFramesThatAreOutAlready) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Pair(1000), kStart);
  assembler.TakeReady(kStart);
  assembler.Add(Imu(1000), kStart);
  assembler.Add(Prior(999, PriorKind::kAttitude));
  assembler.Add(Imu(1001), kStart);
  assembler.Add(Pair(1001), kStart);
  const auto frame = assembler.TakeReady(kStart);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->samples.imu.size(), 1u);
  EXPECT_TRUE(frame->samples.priors.empty());
  EXPECT_EQ(assembler.num_imu_gaps(), 1);
}

TEST(FrameAssemblerTest, PutsPriorsOfTwoProgramsInOrder) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Prior(10, PriorKind::kAttitude));
  assembler.Add(Prior(30, PriorKind::kAttitude));
  assembler.Add(Prior(20, PriorKind::kLegOdometry));
  assembler.Add(Prior(40, PriorKind::kLegOdometry));
  assembler.Add(Pair(35), kStart);
  const auto frame = assembler.TakeReady(kStart);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->samples.priors.size(), 3u);
  EXPECT_EQ(frame->samples.priors[1].t.ns, 20 * kMs);
}

TEST(FrameAssemblerTest, LeavesOutPairsWhoseTimeDoesNotRise) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Pair(1000), kStart);
  assembler.Add(Pair(1000), kStart);
  assembler.Add(Pair(900), kStart);
  EXPECT_TRUE(assembler.TakeReady(kStart));
  EXPECT_FALSE(assembler.TakeReady(kStart));
  EXPECT_EQ(assembler.num_time_jumps(), 2);
}

TEST(FrameAssemblerTest, IsNotShutOutByOneWildTimeStamp) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Pair(1000), kStart);
  assembler.Add(Pair(100'000'000), kStart);
  assembler.Add(Pair(1033), kStart);
  assembler.Add(Pair(1066), kStart);
  for (const int ms : {1000, 1033, 1066}) EXPECT_EQ(assembler.TakeReady(kStart)->pair.t_capture.ns, ms * kMs);
  EXPECT_EQ(assembler.num_time_jumps(), 1);
}

TEST(FrameAssemblerTest, BelievesAJumpOfTheClockThatTheNextFrameConfirms) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Pair(1000), kStart);
  assembler.Add(Pair(100'000), kStart);
  assembler.Add(Pair(100'033), kStart);
  EXPECT_EQ(assembler.TakeReady(kStart)->pair.t_capture.ns, 1000 * kMs);
  EXPECT_EQ(assembler.TakeReady(kStart)->pair.t_capture.ns, 100'033 * kMs);
}

TEST(FrameAssemblerTest, BelievesAClockThatWasSetBackOnceTwoPairsAgree) {
  FrameAssembler assembler{LiveConfig()};
  assembler.Add(Imu(4'000'000), kStart);
  assembler.Add(Pair(4'000'001), kStart);
  EXPECT_TRUE(assembler.TakeReady(kStart + milliseconds(200)));
  assembler.Add(Pair(400'000), kStart);
  assembler.Add(Imu(400'030), kStart);
  assembler.Add(Imu(400'035), kStart);
  EXPECT_FALSE(assembler.TakeAny()) << "one alone may be wild";
  EXPECT_EQ(assembler.TakeClockChange().count(), 0);
  assembler.Add(Pair(400'033), kStart);
  assembler.Add(Imu(400'040), kStart);
  const auto frame = assembler.TakeAny();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pair.t_capture.ns, 400'033 * kMs);
  EXPECT_EQ(assembler.TakeClockChange().count(), (400'033 - 4'000'001) * kMs);
  EXPECT_EQ(assembler.TakeClockChange().count(), 0) << "told once";
  assembler.Add(Pair(400'066), kStart);
  const auto next = assembler.TakeAny();
  ASSERT_TRUE(next);
  EXPECT_FALSE(next->samples.imu.empty()) << "the IMU's clock is believed, too";
}

TEST(FrameAssemblerTest, CountsGapsOfTheImu) {
  FrameAssembler assembler{LiveConfig()};
  for (const int ms : {0, 5, 10, 200, 205, 205}) assembler.Add(Imu(ms), kStart);
  EXPECT_EQ(assembler.num_imu_gaps(), 2) << "one hole, one sample that came twice";
}

TEST(FrameAssemblerTest, KeepsLittleWhenNoImagesCome) {
  FrameAssembler assembler{LiveConfig()};
  for (int ms = 0; ms < 100'000; ++ms) assembler.Add(Imu(ms), kStart);
  assembler.Add(Pair(100'000), kStart);
  EXPECT_LT(assembler.TakeAny()->samples.imu.size(), 20'000u);
}

}  // namespace
}  // namespace terrace
