// SPDX-License-Identifier: BSD-3-Clause
// What an odometry makes of two cameras that stand otherwise to each other than the calibration says, or do
// not see the same moment.
#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "odometry/visual_odometry.h"
#include "test/odometry/tiny_world.h"

namespace terrace {
namespace {

using namespace test;

/// Everything so many columns further to the right, or to the left.
cv::Mat1b Shifted(const cv::Mat1b& image, int columns) {
  cv::Mat1b shifted = image.clone();
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) shifted(v, u) = image(v, std::clamp(u - columns, 0, image.cols - 1));
  return shifted;
}

StereoFrame WithColumnsOff(int frame, int columns) {
  StereoFrame seen = World().Frame(frame, Walk(frame));
  seen.right = Shifted(seen.right, columns);
  return seen;
}

StereoFrame WithLateCamera(int frame, double right_late, double left_late) {
  StereoFrame seen = World().Frame(frame, Walk(frame - left_late));
  seen.right = World().Frame(frame, Walk(frame - right_late)).right;
  return seen;
}

/// The first frame whose pose is told to be in doubt with this word, and from which on none is trusted; -1:
/// none.
template <typename FrameAt>
int FirstDoubted(const FrameAt& frame_at, int num_frames, const std::string& word) {
  VisualOdometry odometry({}, kCamera, {});
  int first = -1;
  for (int i = 0; i < num_frames; ++i) {
    const PoseEstimate pose = odometry.Track(frame_at(i), {});
    if (first < 0 && pose.reason.find(word) != std::string::npos) first = i;
    EXPECT_FALSE(first >= 0 && pose.trusted) << i;
  }
  return first;
}

TEST(PairDoubtTest, TellsColumnsThatAreOffByHowThingsMove) {
  for (const int columns : {-3, -2, 2, 3}) {
    const int told = FirstDoubted([=](int i) { return WithColumnsOff(i, columns); }, 60, "columns");
    EXPECT_GE(told, 0) << columns;
    EXPECT_LE(told, 15) << columns << ": within a second";
  }
}

TEST(PairDoubtTest, SaysNothingOfAGoodPair) {
  VisualOdometry odometry({}, kCamera, {});
  for (int i = 0; i < 40; ++i) {
    const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), {});
    EXPECT_TRUE(pose.trusted) << i << ": " << pose.reason;
  }
}

TEST(PairDoubtTest, SaysNothingOfAGoodPairThatBeginsToMove) {
  // The first millimetres know nothing of columns, and must not seem to.
  for (const double speed : {0.0001, 0.0005, 0.001, 0.002, 0.005, 0.1}) {
    VisualOdometry odometry({}, kCamera, {});
    for (int i = 0; i < 30; ++i) {
      const double moved = i < 3 ? 0.0 : speed * (i - 3) * (i - 3);
      const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(moved)), {});
      EXPECT_TRUE(pose.trusted) << speed << ", " << i << ": " << pose.reason;
    }
  }
}

TEST(PairDoubtTest, SaysNothingOfARobotThatStands) {
  VisualOdometry odometry({}, kCamera, {});
  for (int i = 0; i < 10; ++i) {
    StereoFrame seen = World().Frame(i, Walk(0));
    seen.right = Shifted(seen.right, 3);
    EXPECT_TRUE(odometry.Track(seen, {}).reason.empty()) << "nothing can be known of it";
  }
}

TEST(PairDoubtTest, TellsACameraThatIsAFrameLate) {
  const int right = FirstDoubted([](int i) { return WithLateCamera(i, 1.0, 0.0); }, 30, "late");
  EXPECT_GE(right, 0);
  EXPECT_LE(right, 10);
  const int left = FirstDoubted([](int i) { return WithLateCamera(i, 0.0, 1.0); }, 30, "late");
  EXPECT_GE(left, 0);
  EXPECT_LE(left, 10);
}

/// Its lower half, or its upper quarter, is that of the frame before.
StereoFrame Torn(int frame, bool lower) {
  StereoFrame seen = World().Frame(frame, Walk(frame));
  const StereoFrame before = World().Frame(frame, Walk(frame - 1));
  const int height = seen.left.rows;
  const cv::Range rows = lower ? cv::Range(height / 2, height) : cv::Range(0, height / 4);
  before.left.rowRange(rows).copyTo(seen.left.rowRange(rows));
  before.right.rowRange(rows).copyTo(seen.right.rowRange(rows));
  return seen;
}

TEST(PairDoubtTest, TellsImagesThatAreTorn) {
  for (const bool lower : {true, false}) {
    VisualOdometry odometry({}, kCamera, {});
    int num_told = 0;
    for (int i = 0; i < 30; ++i) {
      const PoseEstimate pose = odometry.Track(i < 15 ? World().Frame(i, Walk(i)) : Torn(i, lower), {});
      const bool told = pose.reason.find("torn") != std::string::npos;
      EXPECT_FALSE(i < 15 && told) << i;
      num_told += told;
    }
    EXPECT_GT(num_told, 0) << (lower ? "below" : "above");
  }
}

TEST(PairDoubtTest, IsLessSureBeforeMotionHasShownThatThePairIsRight) {
  // A camera that is a frame late is off by as much as the robot moves in a frame.
  VisualOdometry odometry({}, kCamera, {});
  for (int i = 0; i < 3; ++i) {
    const PoseEstimate pose = odometry.Track(WithLateCamera(i, 0.0, 1.0), {});
    ASSERT_TRUE(pose.trusted) << "nothing can be known of it yet";
    if (i == 0) continue;
    const double frame_m = (Walk(i).translation() - Walk(i - 1).translation()).norm();
    EXPECT_GT(std::sqrt(pose.covariance.bottomRightCorner<3, 3>().trace()), 0.5 * frame_m) << i;
  }
}

TEST(PairDoubtTest, BelievesTheTwoAgainOnceTheyAreOfOneMoment) {
  VisualOdometry odometry({}, kCamera, {});
  for (int i = 0; i < 15; ++i) odometry.Track(WithLateCamera(i, 1.0, 0.0), {});
  bool trusted = false;
  for (int i = 15; i < 75; ++i) trusted = odometry.Track(World().Frame(i, Walk(i)), {}).trusted;
  EXPECT_TRUE(trusted);
}

}  // namespace
}  // namespace terrace
