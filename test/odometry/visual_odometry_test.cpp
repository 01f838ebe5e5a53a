// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/visual_odometry.h"

#include <cmath>
#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "odometry/rotation.h"
#include "test/odometry/tiny_world.h"

namespace terrace {
namespace {

using namespace test;

TEST(VisualOdometryTest, TellsWhatBecameOfTheLandmarks) {
  VisualOdometry odometry({}, kCamera, {});
  odometry.Track(World().Frame(0, Walk(0)), {});
  EXPECT_TRUE(odometry.sightings().is_keyframe);
  std::map<std::int64_t, Eigen::Vector2f> created;
  for (const LandmarkSighting& sighting : odometry.sightings().landmarks) {
    EXPECT_EQ(sighting.fate, LandmarkFate::kCreated);
    created[sighting.landmark] = sighting.pixel;
  }
  ASSERT_GT(created.size(), 50u);
  // From where it stands: every landmark is where it began.
  const PoseEstimate pose = odometry.Track(World().Frame(1, Walk(0)), {});
  EXPECT_FALSE(odometry.sightings().is_keyframe);
  int num_agree = 0;
  for (const LandmarkSighting& sighting : odometry.sightings().landmarks) {
    if (sighting.fate != LandmarkFate::kAgrees) continue;
    ++num_agree;
    ASSERT_TRUE(created.contains(sighting.landmark));
    EXPECT_LT((sighting.pixel - created[sighting.landmark]).norm(), 0.2F);
  }
  EXPECT_EQ(num_agree, pose.num_inliers);
  odometry.Bridge(2, Timestamp{1'132'000'000}, {}, "no image");
  EXPECT_TRUE(odometry.sightings().landmarks.empty());
}

TEST(VisualOdometryTest, BelievesTheBodyUnderACameraOnItsSideOnceItSeesTheFloor) {
  Eigen::Isometry3d T_start_left = Eigen::Isometry3d::Identity();
  T_start_left.rotate(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ()));
  Eigen::Matrix3d R_body_start;
  R_body_start << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Mounting mounting;
  mounting.T_body_left = Eigen::Isometry3d(R_body_start) * T_start_left;
  VisualOdometry odometry({}, kCamera, mounting);
  const PoseEstimate pose = odometry.Track(World().Frame(0, T_start_left), {});
  ASSERT_EQ(pose.status, TrackingStatus::kTracking) << pose.reason;
  EXPECT_TRUE(pose.T_world_left.linear().isApprox(mounting.T_body_left->linear(), 1e-9))
      << "the body stands level";
  EXPECT_EQ(odometry.gravity().source, GravitySource::kMounting);
  ASSERT_EQ(odometry.warnings().size(), 1u);
  EXPECT_NE(odometry.warnings()[0].find("the floor confirms"), std::string::npos);
  // The axes of a sensor that is mounted so beside a level camera find no floor.
  VisualOdometry beside_sensor({}, kCamera, mounting);
  beside_sensor.Track(World().Frame(0, Eigen::Isometry3d::Identity()), {});
  EXPECT_EQ(beside_sensor.gravity().source, GravitySource::kAssumed);
}

TEST(VisualOdometryTest, FollowsABouncingWalkToAMillimetre) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 24; ++i) {
    const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), {});
    ASSERT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    if (i == 0) {
      first = pose;
      EXPECT_TRUE(pose.covariance.isZero());
    }
    EXPECT_LT(ErrorMm(first, pose, i), 2.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, DoesWithoutAnImuThatTurnsOtherwiseThanTheImages) {
  VisualOdometry odometry({}, kCamera, WithImu());
  PoseEstimate first;
  for (int i = 0; i < 40; ++i) {
    SensorSamples samples = ImuUpTo(i);
    for (ImuSample& sample : samples.imu) sample.gyro.y() += 2.0;
    const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), samples);
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i;
    EXPECT_LT(ErrorMm(first, pose, i), 20.0) << "frame " << i;
  }
  ASSERT_EQ(odometry.warnings().size(), 1u);
  EXPECT_NE(odometry.warnings()[0].find("IMU"), std::string::npos);
}

TEST(VisualOdometryTest, KnowsUpByItsMountingWhenTheImuMeasuresNonsense) {
  for (const double factor : {1.0 / 9.81, -1.0, 0.0}) {
    Mounting mounting = WithImu();
    mounting.T_body_left = WithBody().T_body_left;
    VisualOdometry odometry({}, kCamera, mounting);
    StereoFrame frame = World().Frame(0, Walk(0));  // stands still
    for (int i = 0; i < 10; ++i) {
      SensorSamples samples = ImuUpTo(i);
      for (ImuSample& sample : samples.imu) {
        sample.gyro.setZero();
        sample.accel = -factor * kGravityMagnitude * Eigen::Vector3d::UnitY();
      }
      frame.frame_id = i;
      frame.t_capture = Timestamp{1'000'000'000 + i * kFrame_ns};
      const PoseEstimate pose = odometry.Track(frame, samples);
      EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "factor " << factor << ", frame " << i;
    }
    EXPECT_EQ(odometry.gravity().source, GravitySource::kMounting) << "factor " << factor;
    EXPECT_LT(std::acos(odometry.gravity().down_world.dot(-Eigen::Vector3d::UnitZ())), 0.04)
        << "factor " << factor;
    ASSERT_EQ(odometry.warnings().size(), 1u);
    EXPECT_NE(odometry.warnings()[0].find("IMU"), std::string::npos) << odometry.warnings()[0];
  }
}

TEST(VisualOdometryTest, TakesUpFromTheBodysAttitudeUnlessToldNotTo) {
  for (const bool use_priors : {true, false}) {
    OdometryConfig config;
    config.use_priors = use_priors;
    VisualOdometry odometry(config, kCamera, WithBody());
    for (int i = 0; i < 6; ++i) {
      SensorSamples samples;
      samples.priors.push_back(PriorAt(i, PriorKind::kAttitude));
      const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), samples);
      const Eigen::Vector3d down_left =
          pose.T_world_left.linear().transpose() * odometry.gravity().down_world;
      if (use_priors) {
        EXPECT_LT(std::acos(down_left.dot(Walk(i).linear().transpose() * Eigen::Vector3d::UnitY())), 0.003);
      }
    }
    EXPECT_EQ(odometry.gravity().source, use_priors ? GravitySource::kAttitude : GravitySource::kMounting);
  }
}

TEST(VisualOdometryTest, WalksOnWithItsOldLandmarksWhileTheRightImageIsLost) {
  OdometryConfig config;
  config.window_keyframes = 3;  // so that new ones would soon drive out the old
  config.keyframe_parallax = 0.01;
  VisualOdometry odometry(config, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 40; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    if (i >= 16 && i < 32) frame.right.setTo(3);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i;
    EXPECT_LT(ErrorMm(first, pose, i), 4.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, StandsStillUnderNoiseAndChangingExposure) {
  VisualOdometry odometry({}, kCamera, {});
  std::mt19937 random(2);
  PoseEstimate first;
  for (int i = 0; i < 12; ++i) {
    StereoFrame frame = World().Frame(i, Walk(0), 1.0 + 0.3 * std::sin(i));
    for (cv::Mat1b* image : {&frame.left, &frame.right})
      for (std::uint8_t& grey : *image)
        grey = cv::saturate_cast<std::uint8_t>(grey + static_cast<int>(random() % 7) - 3);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    EXPECT_LT(ErrorMm(first, pose, 0), 1.0) << "frame " << i;
  }
}

/// Rows are read out one after the other while the hand trembles: each lies a little aside.
void ShakeRows(StereoFrame& frame) {
  for (cv::Mat1b* image : {&frame.left, &frame.right}) {
    cv::Mat1f u(image->size()), v(image->size());
    for (int row = 0; row < image->rows; ++row) {
      const double aside = 0.7 * std::sin(0.06 * row + 2.1 * static_cast<double>(frame.frame_id));
      for (int column = 0; column < image->cols; ++column) {
        u(row, column) = static_cast<float>(column + aside);
        v(row, column) = static_cast<float>(row);
      }
    }
    cv::Mat1b shaken;
    cv::remap(*image, shaken, u, v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    *image = shaken;
  }
}

TEST(VisualOdometryTest, FollowsAWalkSeenThroughARollingShutter) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 12; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    ShakeRows(frame);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    ASSERT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    EXPECT_LT(ErrorMm(first, pose, i), 15.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<Eigen::Matrix4d> poses[2];
  for (int run = 0; run < 2; ++run) {
    cv::setNumThreads(run == 0 ? 1 : 3);
    VisualOdometry odometry({}, kCamera, {});
    for (int i = 0; i < 8; ++i)
      poses[run].push_back(odometry.Track(World().Frame(i, Walk(i)), {}).T_world_left.matrix());
  }
  cv::setNumThreads(-1);
  EXPECT_EQ(poses[0], poses[1]);
}

TEST(VisualOdometryTest, WaitsForSomethingToSee) {
  VisualOdometry odometry({}, kCamera, {});
  StereoFrame black = World().Frame(0, Walk(0));
  black.left.setTo(0);
  black.right.setTo(0);
  const PoseEstimate nothing = odometry.Track(black, {});
  EXPECT_EQ(nothing.status, TrackingStatus::kLost);
  EXPECT_FALSE(nothing.reason.empty());
  EXPECT_EQ(odometry.Track(World().Frame(1, Walk(0)), {}).status, TrackingStatus::kTracking);
}

TEST(VisualOdometryTest, TakesUpFromPlanesOnlyWhenNothingBetterIsKnown) {
  VisualOdometry odometry({}, kCamera, {});
  odometry.Track(World().Frame(0, Walk(0)), {});
  EXPECT_EQ(odometry.gravity().source, GravitySource::kAssumed);
  GravityHint hint;
  hint.down_world = Eigen::Vector3d(0.1, 0.0, -1.0).normalized();
  hint.sigma_rad = 0.01;
  odometry.Apply(hint);
  EXPECT_EQ(odometry.gravity().source, GravitySource::kPlane);
  EXPECT_TRUE(odometry.gravity().down_world.isApprox(hint.down_world));
  GravityHint worse = hint;
  worse.down_world = -Eigen::Vector3d::UnitZ();
  worse.sigma_rad = 0.1;
  odometry.Apply(worse);
  EXPECT_TRUE(odometry.gravity().down_world.isApprox(hint.down_world));
}

TEST(VisualOdometryTest, IsInDoubtAboutPoseAndGravityWhileThePairIsSaidToBeWrong) {
  VisualOdometry odometry({}, kCamera, {});
  odometry.Track(World().Frame(0, Walk(0)), {});
  odometry.Apply({.down_world = -Eigen::Vector3d::UnitZ(), .sigma_rad = 0.01});
  odometry.Hear({.reason = "the right image is rolled", .code = ReasonCode::kBadCalibration});
  const PoseEstimate doubted = odometry.Track(World().Frame(1, Walk(1)), {});
  EXPECT_FALSE(doubted.trusted);
  EXPECT_EQ(doubted.reason, "the right image is rolled");
  EXPECT_EQ(doubted.reason_code, ReasonCode::kBadCalibration);
  EXPECT_GT(odometry.gravity().sigma_rad, 0.05);
  odometry.Hear({});
  EXPECT_TRUE(odometry.Track(World().Frame(2, Walk(2)), {}).trusted);
}

TEST(VisualOdometryTest, NamesTheCalibrationWhenTheRightImageLiesLower) {
  VisualOdometry odometry({}, kCamera, {});
  StereoFrame frame = World().Frame(0, Walk(0));
  cv::Mat lower;
  cv::copyMakeBorder(frame.right.rowRange(0, frame.right.rows - 1), lower, 1, 0, 0, 0, cv::BORDER_REPLICATE);
  frame.right = lower;
  for (int i = 0; i < 60; ++i) {
    frame.frame_id = i;
    frame.t_capture = Timestamp{1'000'000'000 + i * 66'000'000ll};
    odometry.Track(frame, {});
  }
  ASSERT_EQ(odometry.warnings().size(), 1u);
  EXPECT_NE(odometry.warnings()[0].find("calibrat"), std::string::npos);
}

}  // namespace
}  // namespace terrace
