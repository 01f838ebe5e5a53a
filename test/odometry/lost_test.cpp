// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "odometry/covariance.h"
#include "odometry/rotation.h"
#include "odometry/visual_odometry.h"
#include "test/odometry/tiny_world.h"

namespace terrace {
namespace {

using namespace test;

TEST(BridgingTest, BridgesBlackFramesAndSaysSoAndFindsBack) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first, pose;
  double sigma_before = 0.0;
  for (int i = 0; i < 20; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    const bool black = i >= 12 && i < 16;
    if (black) {
      frame.left.setTo(2);
      frame.right.setTo(2);
    }
    pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    EXPECT_EQ(pose.reason.empty(), !black);
    EXPECT_EQ(pose.trusted, !black);
    if (black) {
      EXPECT_GT(pose.covariance(5, 5), sigma_before) << "frame " << i;
    }
    sigma_before = pose.covariance(5, 5);
  }
  EXPECT_LT(ErrorMm(first, pose, 19), 3.0);
}

TEST(BridgingTest, KnowsWithAnImuWhereDownIsAndWalksOnThroughTheDark) {
  VisualOdometry odometry({}, kCamera, WithImu());
  PoseEstimate first;
  for (int i = 0; i < 30; ++i) {
    const StereoFrame frame = World().Frame(i, Walk(i));
    const bool black = i >= 20 && i < 26;
    const PoseEstimate pose = odometry.Track(black ? Black(frame) : frame, ImuUpTo(i));
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    EXPECT_LT(ErrorMm(first, pose, i), black ? 15.0 : 2.0) << "frame " << i;
  }
  EXPECT_EQ(odometry.gravity().source, GravitySource::kImu);
  const Eigen::Vector3d down_left = first.T_world_left.linear().transpose() * odometry.gravity().down_world;
  EXPECT_LT(std::acos(down_left.dot(Walk(0).linear().transpose() * Eigen::Vector3d::UnitY())), 0.02);
}

/// Mean normalised error squared (6 is honest) of frames that were bridged through gaps of one to five
/// frames.
double BridgingNees(bool with_imu) {
  VisualOdometry odometry({}, kCamera, with_imu ? WithImu() : Mounting{});
  std::mt19937 random(3);
  PoseEstimate first;
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 70; ++i) {
    constexpr int kEvery = 10;
    const bool black = i >= 20 && i % kEvery < i / kEvery - 1;
    const StereoFrame frame = World().Frame(i, Walk(i));
    const PoseEstimate pose = odometry.Track(black ? Black(frame) : frame,
                                             with_imu ? WithNoise(ImuUpTo(i), random) : SensorSamples{});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    if (!black) continue;
    const Vector6d error = StepBetween(Walk(0).inverse() * Walk(i), FromStart(first, pose));
    sum += Chi2(error, pose.covariance);
    ++count;
  }
  return sum / count;
}

TEST(BridgingTest, KnowsHowWrongItIsWhileItBridges) {
  for (const bool with_imu : {false, true}) {
    const double nees = BridgingNees(with_imu);
    EXPECT_GT(nees, 1.0) << (with_imu ? "with IMU" : "without IMU");
    EXPECT_LT(nees, 12.0) << (with_imu ? "with IMU" : "without IMU");
  }
}

TEST(BridgingTest, FollowsTheLegsThroughTheDark) {
  double error_mm[2];
  for (const bool use_priors : {true, false}) {
    OdometryConfig config;
    config.use_priors = use_priors;
    VisualOdometry odometry(config, kCamera, WithBody());
    PoseEstimate first, pose;
    for (int i = 0; i < 16; ++i) {
      SensorSamples samples;
      samples.priors.push_back(PriorAt(i, PriorKind::kLegOdometry));
      const StereoFrame frame = World().Frame(i, Walk(i));
      pose = odometry.Track(i < 10 ? frame : Black(frame), samples);
      if (i == 0) first = pose;
    }
    EXPECT_EQ(pose.status, TrackingStatus::kBridging);
    error_mm[use_priors] = ErrorMm(first, pose, 15);
  }
  EXPECT_LT(error_mm[true], 3.0);
  EXPECT_GT(error_mm[false], 10.0);
}

TEST(BridgingTest, IsLostAfterBridgingTooLongAndFindsBackToItsKeyframes) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first, pose;
  for (int i = 0; i < 8; ++i) {
    pose = odometry.Track(World().Frame(i, Walk(i)), {});
    if (i == 0) first = pose;
  }
  for (int i = 8; i < 50; ++i)
    pose = odometry.Bridge(i, Timestamp{1'000'000'000 + i * 66'000'000ll}, {}, "the image cannot be read");
  EXPECT_EQ(pose.status, TrackingStatus::kLost);
  EXPECT_EQ(pose.reason, "the image cannot be read");
  StereoFrame frame = World().Frame(50, Walk(8));
  pose = odometry.Track(frame, {});
  EXPECT_EQ(pose.status, TrackingStatus::kTracking);
  EXPECT_LT(ErrorMm(first, pose, 8), 3.0);
}

TEST(BridgingTest, FindsTheWayAfterAGapInWhichTheCameraWalkedOn) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first, pose;
  for (int i = 0; i < 26; ++i) {
    if (i >= 12 && i < 22) continue;
    pose = odometry.Track(World().Frame(i, Walk(i)), {});
    if (i == 0) first = pose;
  }
  EXPECT_EQ(pose.status, TrackingStatus::kTracking);
  EXPECT_LT(ErrorMm(first, pose, 25), 4.0);
}

/// Fails unless what was given out is a pose that a robot can have; the one before is null at the start.
void ExpectPossible(const PoseEstimate& pose, const PoseEstimate* before, int frame) {
  const Eigen::Matrix3d R = pose.T_world_left.linear();
  ASSERT_TRUE(pose.T_world_left.matrix().allFinite()) << "frame " << frame;
  ASSERT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-9) << "frame " << frame;
  ASSERT_TRUE(pose.covariance.allFinite()) << "frame " << frame;
  if (!before || before->epoch != pose.epoch) return;
  ASSERT_LT((pose.T_world_left.translation() - before->T_world_left.translation()).norm(), 1.5)
      << "frame " << frame;
}

/// The error of a pose within its epoch, which began at a frame that is given.
Vector6d ErrorInEpoch(const PoseEstimate& first, int first_frame, const PoseEstimate& pose, double frame) {
  return StepBetween(Walk(first_frame).inverse() * Walk(frame), FromStart(first, pose));
}

/// A frame that shows nothing.
StereoFrame Darkness(int frame) {
  StereoFrame dark;
  dark.frame_id = frame;
  dark.t_capture = Timestamp{1'000'000'000 + frame * kFrame_ns};
  dark.left = cv::Mat1b(kCamera.height, kCamera.width, std::uint8_t{2});
  dark.right = dark.left;
  return dark;
}

TEST(LostTest, StartsAgainAfterALongDarkWithAnImu) {
  constexpr int kDarkFrom = 12, kDarkUntil = 46;  // longer than bridging may last
  VisualOdometry odometry({}, kCamera, WithImu());
  PoseEstimate first, before, pose;
  int first_frame = 0, num_tracked_after = 0;
  for (int i = 0; i < kDarkUntil + 8; ++i) {
    const bool dark = i >= kDarkFrom && i < kDarkUntil;
    pose = odometry.Track(dark ? Darkness(i) : World().Frame(i, Walk(i)), ImuUpTo(i));
    ASSERT_NO_FATAL_FAILURE(ExpectPossible(pose, i > 0 ? &before : nullptr, i));
    if (i == 0 || pose.epoch != before.epoch) {
      first = pose;
      first_frame = i;
    }
    before = pose;
    if (i < kDarkUntil || pose.status != TrackingStatus::kTracking) continue;
    ++num_tracked_after;
    if (pose.covariance.isZero()) continue;  // the first of its epoch
    EXPECT_LT(Chi2(ErrorInEpoch(first, first_frame, pose, i), pose.covariance), 60.0) << "frame " << i;
  }
  EXPECT_EQ(pose.status, TrackingStatus::kTracking);
  EXPECT_GE(num_tracked_after, 4);
}

TEST(LostTest, OutlivesImuSamplesThatNobodyCanHaveMeasured) {
  for (const double wild : {1e6, std::numeric_limits<double>::quiet_NaN()}) {
    VisualOdometry odometry({}, kCamera, WithImu());
    PoseEstimate first;
    for (int i = 0; i < 22; ++i) {
      SensorSamples samples = ImuUpTo(i);
      if (i == 12) samples.imu[5].accel.x() = wild;
      if (i == 15) samples.imu[7].gyro.y() = wild;
      const bool black = i >= 12 && i < 17;
      const PoseEstimate pose = odometry.Track(black ? Darkness(i) : World().Frame(i, Walk(i)), samples);
      if (i == 0) first = pose;
      EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
      EXPECT_LT(ErrorMm(first, pose, i), black ? 25.0 : 3.0) << "frame " << i;
    }
    EXPECT_EQ(odometry.warnings().size(), 1u);
  }
}

TEST(LostTest, RecognisesThePlaceWhereItWasLost) {
  for (const bool tell_it_blind : {false, true}) {
    VisualOdometry odometry({}, kCamera, WithImu());
    PoseEstimate first, pose;
    for (int i = 0; i < 10; ++i) {
      pose = odometry.Track(World().Frame(i, Walk(i)), ImuUpTo(i));
      if (i == 0) first = pose;
    }
    constexpr int kBlind = 75;  // five seconds; the IMU says that it walks on
    for (int i = 10; tell_it_blind && i < 10 + kBlind; ++i)
      odometry.Bridge(i, Timestamp{1'000'000'000 + i * kFrame_ns}, ImuUpTo(i), "the image cannot be read");
    for (int k = 0; k < 6; ++k) pose = odometry.Track(World().Frame(10 + kBlind + k, Walk(4 + k)), {});
    EXPECT_EQ(pose.status, TrackingStatus::kTracking);
    EXPECT_EQ(pose.epoch, 0);
    EXPECT_LT(ErrorMm(first, pose, 9), 4.0);
  }
}

TEST(LostTest, FindsBackWhenThePlayerOfARecordingIsStartedAgain) {
  VisualOdometry odometry({}, kCamera, WithImu());
  std::mt19937 random(3);
  PoseEstimate first, pose;
  constexpr int kAgain = 60;
  for (int i = 0; i < kAgain + 20; ++i) {
    const int shown = i < kAgain ? i : i - kAgain;
    StereoFrame frame = World().Frame(i, Walk(shown));
    SensorSamples samples = WithNoise(ImuUpTo(shown), random);
    for (ImuSample& sample : samples.imu) sample.t.ns += (i - shown) * kFrame_ns;
    pose = odometry.Track(frame, samples);
    if (i == 0) first = pose;
    if (pose.trusted) {
      EXPECT_LT(ErrorMm(first, pose, shown), 15.0) << "frame " << i;
    }
  }
  EXPECT_TRUE(pose.trusted);
  EXPECT_EQ(pose.epoch, 0) << "the place is known";
}

TEST(LostTest, BeginsAnotherWorldWhereNothingIsKnown) {
  for (const bool tell_it_blind : {false, true}) {
    VisualOdometry odometry({}, kCamera, {});
    const TinyWorld elsewhere(kTextureSize, 2);
    for (int i = 0; i < 10; ++i) odometry.Track(World().Frame(i, Walk(i)), {});
    constexpr int kBlind = 75;
    for (int i = 10; tell_it_blind && i < 10 + kBlind; ++i)
      odometry.Bridge(i, Timestamp{1'000'000'000 + i * kFrame_ns}, {}, "the image cannot be read");
    PoseEstimate first, pose;
    int first_k = -1;
    for (int k = 0; k < 10; ++k) {
      pose = odometry.Track(elsewhere.Frame(10 + kBlind + k, Walk(k)), {});
      if (pose.status != TrackingStatus::kTracking) {
        EXPECT_EQ(pose.epoch, 0);
        EXPECT_FALSE(pose.trusted);
        continue;
      }
      if (first_k < 0) {
        first = pose;
        first_k = k;
        EXPECT_TRUE(pose.covariance.isZero());
        EXPECT_TRUE(pose.trusted);
      }
      EXPECT_EQ(pose.epoch, 1);
      EXPECT_LT(1e3 * ErrorInEpoch(first, first_k, pose, k).tail<3>().norm(), 3.0) << "frame " << k;
    }
    EXPECT_EQ(pose.status, TrackingStatus::kTracking);
    EXPECT_LE(first_k, 6);
  }
}

TEST(LostTest, GoesOnWhenTheClockIsSetBack) {
  VisualOdometry odometry({}, kCamera, WithImu());
  PoseEstimate first, pose;
  for (int i = 0; i < 12; ++i) {
    pose = odometry.Track(World().Frame(i, Walk(i)), ImuUpTo(i));
    if (i == 0) first = pose;
  }
  for (int k = 0; k < 12; ++k) {
    pose = odometry.Track(World().Frame(k, Walk(k)), ImuUpTo(k));
    EXPECT_TRUE(pose.T_world_left.matrix().allFinite());
  }
  EXPECT_EQ(pose.status, TrackingStatus::kTracking);
  EXPECT_EQ(pose.epoch, 0);
  EXPECT_LT(ErrorMm(first, pose, 11), 4.0);
}

}  // namespace
}  // namespace terrace
