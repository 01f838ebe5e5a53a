// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "odometry/covariance.h"
#include "odometry/rotation.h"
#include "odometry/visual_odometry.h"
#include "test/odometry/tiny_world.h"

namespace terrace {
namespace {

using namespace test;

/// A textured board at 0.5 m that swings through the view and covers a third of it, unless told otherwise.
void HoldBoardInto(StereoFrame& frame, double width_share = 0.5, double height_share = 2.0 / 3.0) {
  constexpr int kDisparityPx = 48;
  const auto i = static_cast<double>(frame.frame_id);
  const int width = static_cast<int>(kCamera.width * width_share);
  const int height = static_cast<int>(kCamera.height * height_share);
  const int u0 = static_cast<int>((kCamera.width - width) * (0.5 + 0.5 * std::sin(0.11 * i)));
  const int v0 = static_cast<int>((kCamera.height - height) * (0.5 + 0.5 * std::sin(0.23 * i)));
  cv::Mat1b board(height / 4, width / 4), large;
  std::mt19937 random(7);
  for (std::uint8_t& grey : board) grey = static_cast<std::uint8_t>(60 + random() % 128);
  cv::resize(board, large, {width, height}, 0, 0, cv::INTER_CUBIC);
  large.copyTo(frame.left(cv::Rect(u0, v0, width, height)));
  const int u_right = std::max(u0 - kDisparityPx, 0);
  const int hidden = u_right - (u0 - kDisparityPx);
  large.colRange(hidden, width).copyTo(frame.right(cv::Rect(u_right, v0, width - hidden, height)));
}

TEST(MovingThingsTest, IsNotCarriedAwayByABoardThatMovesThroughTheView) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 45; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    if (i >= 8) HoldBoardInto(frame);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    if (pose.status == TrackingStatus::kTracking) {
      EXPECT_LT(ErrorMm(first, pose, i), 4.0) << "frame " << i;
    }
  }
}

/// A textured board at 0.5 m that covers the view from a column on, over its whole height.
void PutBoardFrom(StereoFrame& frame, int u0, int width) {
  constexpr int kDisparityPx = 48;
  cv::Mat1b board(kCamera.height / 4, width / 4), large;
  std::mt19937 random(7);
  for (std::uint8_t& grey : board) grey = static_cast<std::uint8_t>(60 + random() % 128);
  cv::resize(board, large, {width, kCamera.height}, 0, 0, cv::INTER_CUBIC);
  for (const bool left : {true, false}) {
    cv::Mat1b& image = left ? frame.left : frame.right;
    const int from = u0 - (left ? 0 : kDisparityPx);
    const int begin = std::max(from, 0), end = std::min(from + width, kCamera.width);
    if (begin < end) large.colRange(begin - from, end - from).copyTo(image.colRange(begin, end));
  }
}

TEST(MovingThingsTest, BelievesLegsAtRestWhenWhatFillsTheViewLeavesIt) {
  VisualOdometry odometry({}, kCamera, WithBody());
  PoseEstimate first, pose;
  int num_untrusted = 0;
  for (int i = 0; i < 50; ++i) {
    constexpr int kLeaves = 24, kWidth = 300, kPxAFrame = 20;
    StereoFrame frame = World().Frame(i, Walk(0));
    PutBoardFrom(frame, 20 - kPxAFrame * std::max(0, i - kLeaves), kWidth);
    SensorSamples samples;
    samples.priors.push_back(PriorAt(0, PriorKind::kLegOdometry));
    samples.priors.back().t = frame.t_capture;
    pose = odometry.Track(frame, samples);
    if (i == 0) first = pose;
    num_untrusted += !pose.trusted;
    if (pose.trusted && pose.epoch == 0) {
      EXPECT_LT(ErrorMm(first, pose, 0), 10.0) << "frame " << i;
    }
  }
  EXPECT_GT(num_untrusted, 0);
}

TEST(MovingThingsTest, PublishesNoJumpAsCertainWhenItStumblesBeforeAMovingBoard) {
  int num_doubtful = 0;
  for (const int stumble : {18, 22, 26, 30, 34}) {
    VisualOdometry odometry({}, kCamera, {});
    PoseEstimate first;
    for (int i = 0; i < stumble + 8; ++i) {
      constexpr double kFramesFarther = 3.0;  // 7.5 cm at once, which no motion model expects
      const double at = i >= stumble ? i + kFramesFarther : i;
      StereoFrame frame = World().Frame(i, Walk(at));
      if (i >= 8) HoldBoardInto(frame, 0.65, 0.8);
      const PoseEstimate pose = odometry.Track(frame, {});
      if (i == 0) first = pose;
      const Vector6d error = StepBetween(Walk(0).inverse() * Walk(at), FromStart(first, pose));
      if (pose.trusted) {
        EXPECT_LT(1e3 * error.tail<3>().norm(), 4.0) << "stumbles at " << stumble << ", frame " << i;
      } else {
        EXPECT_LT(Chi2(error, pose.covariance), 20.0) << "stumbles at " << stumble << ", frame " << i;
      }
      num_doubtful += pose.status == TrackingStatus::kTracking && !pose.trusted;
    }
  }
  EXPECT_GT(num_doubtful, 0);
}

TEST(MovingThingsTest, FollowsAJerkOfTheHeadWhereTextureRepeatsItself) {
  const TinyWorld repeating(64);
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 16; ++i) {
    Vector6d jerk = Vector6d::Zero();
    if (i >= 12) jerk[0] = 0.3;  // 60 px at once: farther than patches are followed
    const Eigen::Isometry3d T_start_left = Perturb(Walk(i), jerk);
    const PoseEstimate pose = odometry.Track(repeating.Frame(i, T_start_left), {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i;
    const Vector6d error = StepBetween(Walk(0).inverse() * T_start_left, FromStart(first, pose));
    EXPECT_LT(1e3 * error.tail<3>().norm(), 4.0) << "frame " << i;
  }
}

TEST(MovingThingsTest, BelievesWhatIsNewWhereItHidesWhatIsKnown) {
  TinyWorld world;
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 24; ++i) {
    if (i == 12) world.PutUp({.z_m = 1.2, .right_m = 0.25});  // stands still from then on
    const PoseEstimate pose = odometry.Track(world.Frame(i, Walk(i)), {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    EXPECT_LT(ErrorMm(first, pose, i), 4.0) << "frame " << i;
  }
}

TEST(MovingThingsTest, FollowsAJerkBeforeSlats) {
  TinyWorld world;
  world.PutUp({.z_m = 1.0, .right_m = 10.0, .slat_m = 0.06});
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 16; ++i) {
    Vector6d jerk = Vector6d::Zero();
    if (i >= 12)
      jerk << 0.25, 0.0, 0.0, 0.0, 0.1, 0.0;  // 10 cm down, where coarse patches mix slats and gaps
    const Eigen::Isometry3d T_start_left = Perturb(Walk(i), jerk);
    const PoseEstimate pose = odometry.Track(world.Frame(i, T_start_left), {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    const Vector6d error = StepBetween(Walk(0).inverse() * T_start_left, FromStart(first, pose));
    EXPECT_LT(1e3 * error.tail<3>().norm(), 4.0) << "frame " << i;
  }
}

}  // namespace
}  // namespace terrace
