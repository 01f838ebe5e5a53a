// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/standing_images.h"

#include <gtest/gtest.h>

#include "odometry/visual_odometry.h"
#include "test/odometry/tiny_world.h"

namespace terrace {
namespace {

using namespace test;

TEST(StandingImagesTest, TellsOneCameraThatStandsFromBoth) {
  StandingImages standing;
  StereoFrame frame = World().Frame(0, Walk(0));
  const StereoFrame next = World().Frame(1, Walk(1));
  standing.See(frame);
  EXPECT_FALSE(standing.left_alone() || standing.both());
  standing.See(frame);
  EXPECT_TRUE(standing.both());
  frame.right = next.right;
  standing.See(frame);
  EXPECT_TRUE(standing.left_alone());
  EXPECT_FALSE(standing.both());
  standing.See(next);
  EXPECT_FALSE(standing.left_alone() || standing.both());
  EXPECT_EQ(standing.num_right_alone(), 1);
}

TEST(StandingImagesTest, BridgesByTheImuWhileCamerasThatWalkGiveTheSameImages) {
  VisualOdometry odometry({}, kCamera, WithImu());
  std::mt19937 random(3);
  PoseEstimate first;
  for (int i = 0; i < 40; ++i) {
    const bool frozen = i >= 20 && i < 30;
    StereoFrame frame = World().Frame(i, Walk(frozen ? 19 : i));
    const PoseEstimate pose = odometry.Track(frame, WithNoise(ImuUpTo(i), random));
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, frozen ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    EXPECT_EQ(pose.reason.find("frozen") != std::string::npos, frozen)
        << "frame " << i << ": " << pose.reason;
    if (!frozen) {
      EXPECT_LT(ErrorMm(first, pose, i), 20.0) << "frame " << i;
    }
  }
}

TEST(StandingImagesTest, ACameraThatWalksDoesNotStopWhereBothImagesAreRepeatedNowAndThen) {
  VisualOdometry odometry({}, kCamera, {});
  for (int i = 0; i < 24; ++i) {
    const bool repeated = i > 12 && i % 3 == 0;
    const StereoFrame frame = World().Frame(i, Walk(repeated ? i - 1 : i));
    const PoseEstimate pose = odometry.Track(frame, {});
    EXPECT_EQ(pose.status, repeated ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
  }
}

TEST(StandingImagesTest, DoubtsAFrameWhoseRightImageAloneIsTheOneBefore) {
  VisualOdometry odometry({}, kCamera, {});
  for (int i = 0; i < 20; ++i) {
    const bool old = i > 9 && i % 3 == 0;
    StereoFrame frame = World().Frame(i, Walk(i));
    if (old) frame.right = World().Frame(i - 1, Walk(i - 1)).right;
    const PoseEstimate pose = odometry.Track(frame, {});
    EXPECT_EQ(pose.reason.find("right camera get lost") != std::string::npos, old) << "frame " << i;
    EXPECT_FALSE(old && pose.trusted) << "frame " << i;
  }
}

TEST(StandingImagesTest, TakesARecordingOfOnePairForACameraThatStands) {
  VisualOdometry odometry({}, kCamera, {});
  StereoFrame frame = World().Frame(0, Walk(0));
  for (int i = 0; i < 40; ++i) {
    frame.frame_id = i;
    frame.t_capture = Timestamp{1'000'000'000 + i * kFrame_ns};
    EXPECT_TRUE(odometry.Track(frame, {}).trusted) << "frame " << i;
  }
}

}  // namespace
}  // namespace terrace
