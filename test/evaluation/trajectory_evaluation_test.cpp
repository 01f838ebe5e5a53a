// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/trajectory_evaluation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "test/evaluation/exact.h"

namespace terrace {
namespace {

Timestamp TimeOf(int frame) { return {1'600'000'000'000'000'000 + frame * 100'000'000LL}; }

/// 101 poses 0.1 m apart along x: 10 m.
std::vector<TimedPose> StraightLine() {
  std::vector<TimedPose> poses(101);
  for (int i = 0; i <= 100; ++i) {
    poses[static_cast<std::size_t>(i)].t = TimeOf(i);
    poses[static_cast<std::size_t>(i)].T_world_frame.translation().x() = 0.1 * i;
  }
  return poses;
}

/// A curve through space with turning orientations, so that every alignment is determined.
std::vector<TimedPose> Curve() {
  std::vector<TimedPose> poses(101);
  for (int i = 0; i <= 100; ++i) {
    const double a = 0.05 * i;
    TimedPose& pose = poses[static_cast<std::size_t>(i)];
    pose.t = TimeOf(i);
    pose.T_world_frame.linear() = (Eigen::AngleAxisd(a, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(0.2 * std::sin(3 * a), Eigen::Vector3d::UnitX()))
                                      .toRotationMatrix();
    pose.T_world_frame.translation() =
        Eigen::Vector3d(2 * std::cos(a), 2 * std::sin(a), 0.1 * std::sin(2 * a));
  }
  return poses;
}

std::vector<ResultPose> ResultOf(const std::vector<TimedPose>& truth) {
  std::vector<ResultPose> result;
  for (const TimedPose& pose : truth) result.push_back({pose.t, pose.T_world_frame});
  return result;
}

TrajectoryEvaluation Evaluate(const std::vector<ResultPose>& result, const std::vector<TimedPose>& truth,
                              const std::vector<ResultFrame>& frames = {}) {
  const auto num_truth = static_cast<std::int64_t>(truth.size());
  return EvaluateTrajectory(MatchPoses(result, truth), frames, num_truth, num_truth);
}

Eigen::Isometry3d SomewhereElse() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.3, 0.4, 1.0).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(10, -3, 2);
  return T;
}

TEST(TrajectoryEvaluationTest, SaysWhyNoPoseHasATrueOneAndNamesTheFactorOfAnotherUnit) {
  const std::vector<TimedPose> truth = StraightLine();
  std::vector<TimedPose> in_us = truth, later = truth;
  for (TimedPose& pose : in_us) pose.t.ns /= 1000;
  for (TimedPose& pose : later) pose.t.ns += 3'600'000'000'000;
  ASSERT_TRUE(MatchPoses(ResultOf(truth), in_us).empty());
  EXPECT_EQ(WhyNoneMatches(ResultOf(truth), in_us),
            "no pose has a true one within 2 ms: the poses are of 1600000000.000 to 1600000010.000 s, the "
            "true ones of "
            "1600000.000 to 1600000.010 s; the true ones are in another unit, with the factor 1000 they "
            "would meet");
  const std::string hour = WhyNoneMatches(ResultOf(truth), later);
  EXPECT_EQ(hour.find("another unit"), std::string::npos) << hour;
}

TEST(TrajectoryEvaluationTest, GivesPerfectMarksToTheTruthInAnyWorld) {
  const std::vector<TimedPose> truth = Curve();
  std::vector<ResultPose> result = ResultOf(truth);
  for (ResultPose& pose : result) pose.T_world_left = SomewhereElse() * pose.T_world_left;
  const TrajectoryEvaluation evaluation = Evaluate(result, truth);
  EXPECT_EQ(evaluation.coverage, 1.0);
  EXPECT_NEAR(evaluation.ate_rmse_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.ate_first_pose_rmse_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.rotation_rmse_deg, 0.0, 1e-5);
  ASSERT_NE(evaluation.Segment(1.0), nullptr);
  EXPECT_NEAR(evaluation.Segment(1.0)->translation_pct, 0.0, 1e-6);
  EXPECT_NEAR(evaluation.Segment(1.0)->rotation_deg_per_m, 0.0, 1e-5);
  const Eigen::Isometry3d T = AlignByOrientations(MatchPoses(result, truth));
  EXPECT_TRUE(T.isApprox(SomewhereElse().inverse(), 1e-9));
}

TEST(TrajectoryEvaluationTest, MeasuresATrajectoryScaledByOnePercent) {
  const std::vector<TimedPose> truth = StraightLine();
  std::vector<ResultPose> result = ResultOf(truth);
  for (ResultPose& pose : result) pose.T_world_left.translation() *= 1.01;
  const TrajectoryEvaluation evaluation = Evaluate(result, truth);
  // No alignment may take the scale away. Every piece is 1 % too long, whatever its length.
  for (double length_m : {1.0, 2.0, 5.0, 10.0}) {
    ASSERT_NE(evaluation.Segment(length_m), nullptr);
    EXPECT_NEAR(evaluation.Segment(length_m)->translation_pct, 1.0, 1e-6);
    EXPECT_NEAR(evaluation.Segment(length_m)->rotation_deg_per_m, 0.0, 1e-6);
  }
  EXPECT_EQ(evaluation.Segment(20.0), nullptr);
  // Starts: 10 frames to a metre, so 101 - 10, 101 - 20, 101 - 50, 101 - 100.
  EXPECT_EQ(evaluation.Segment(1.0)->count, 91);
  EXPECT_EQ(evaluation.Segment(2.0)->count, 81);
  EXPECT_EQ(evaluation.Segment(5.0)->count, 51);
  EXPECT_EQ(evaluation.Segment(10.0)->count, 1);
  EXPECT_NEAR(evaluation.mean_of_all.translation_pct, 1.0, 1e-6);
  // Aligned by positions the means agree: the error is 1 % of the distance from the middle. The variance of
  // 0..100 is (101^2 - 1) / 12 = 850, so rms = 0.01 * 0.1 * sqrt(850) = 0.0291548 m.
  EXPECT_NEAR(evaluation.ate_rmse_m, 0.0291548, 1e-7);
  EXPECT_NEAR(evaluation.ate_max_m, 0.05, kExact);
  // From the first pose on: 0.001 * sqrt(mean of i^2) = 0.001 * sqrt(100 * 201 / 6) = 0.0578792 m.
  EXPECT_NEAR(evaluation.ate_first_pose_rmse_m, 0.0578792, 1e-7);
  EXPECT_NEAR(evaluation.end_error_pct, 1.0, 1e-6);
  EXPECT_NEAR(evaluation.path_length_m, 10.0, kExact);
}

TEST(TrajectoryEvaluationTest, MeasuresAYawDriftOfHalfADegreePerMetre) {
  const std::vector<TimedPose> truth = StraightLine();
  std::vector<ResultPose> result = ResultOf(truth);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double yaw_rad = 0.5 * EIGEN_PI / 180.0 * 0.1 * static_cast<double>(i);
    result[i].T_world_left.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  const TrajectoryEvaluation evaluation = Evaluate(result, truth);
  EXPECT_NEAR(evaluation.Segment(1.0)->rotation_deg_per_m, 0.5, 1e-6);
  EXPECT_NEAR(evaluation.Segment(5.0)->rotation_deg_per_m, 0.5, 1e-6);
  // The best single rotation is that of the middle: 0.05 deg * sqrt(850) = 1.45774 deg rms.
  EXPECT_NEAR(evaluation.rotation_rmse_deg, 1.45774, 1e-3);
}

TEST(TrajectoryEvaluationTest, CountsMissingPosesAgainstCoverageOnly) {
  const std::vector<TimedPose> truth = Curve();
  std::vector<ResultPose> result = ResultOf(truth);
  result.erase(result.begin() + 40, result.begin() + 61);  // 21 lost frames
  const TrajectoryEvaluation evaluation = Evaluate(result, truth);
  EXPECT_NEAR(evaluation.coverage, 80.0 / 101.0, kExact);
  EXPECT_NEAR(evaluation.ate_rmse_m, 0.0, kExact);
}

TEST(TrajectoryEvaluationTest, MatchesWithinTwoMilliseconds) {
  const std::vector<TimedPose> truth = StraightLine();
  std::vector<ResultPose> result = ResultOf(truth);
  result[10].t_capture.ns += 1'900'000;
  result[20].t_capture.ns -= 1'900'000;
  result[30].t_capture.ns += 2'100'000;
  EXPECT_EQ(MatchPoses(result, truth).size(), 100u);
}

TEST(TrajectoryEvaluationTest, AsksOfADenseTruthOnlyWhatFramesCouldGive) {
  std::vector<TimedPose> truth;  // ten times as dense as the frames
  for (int i = 0; i < 1000; ++i) {
    truth.push_back({{TimeOf(0).ns + i * 10'000'000LL}, Eigen::Isometry3d::Identity()});
  }
  std::vector<ResultPose> result;
  for (int i = 0; i < 50; ++i) result.push_back({TimeOf(i), Eigen::Isometry3d::Identity()});
  const auto pairs = MatchPoses(result, truth);
  EXPECT_NEAR(EvaluateTrajectory(pairs, {}, 1000, 100).coverage, 0.5, kExact);
}

TEST(TrajectoryEvaluationTest, TurnsRawTruthByTheRectifyingRotationAlone) {
  ResultCamera camera;
  camera.R_rect_raw = Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitY()).toRotationMatrix();
  TrueTrajectory truth;
  truth.frame = TruthFrame::kRawLeft;
  truth.poses = Curve();
  // A point seen along z of the raw camera is seen along R_rect_raw * z of the rectified one.
  const std::vector<TimedPose> left = TrueLeftPoses(truth, camera);
  const Eigen::Vector3d ray_raw(0.1, 0.2, 1.0);
  EXPECT_TRUE((truth.poses[50].T_world_frame * ray_raw)
                  .isApprox(left[50].T_world_frame * (camera.R_rect_raw * ray_raw), 1e-12));

  truth.frame = TruthFrame::kBody;
  EXPECT_THROW(TrueLeftPoses(truth, camera), FileError);
  camera.T_body_left = SomewhereElse();
  EXPECT_TRUE(TrueLeftPoses(truth, camera)[7].T_world_frame.isApprox(
      truth.poses[7].T_world_frame * SomewhereElse(), 1e-12));
}

TEST(TrajectoryEvaluationTest, NormalisesErrorsByTheirCovariance) {
  const std::vector<TimedPose> truth = Curve();
  std::vector<ResultPose> result = ResultOf(truth);
  std::vector<ResultFrame> frames;
  for (std::size_t i = 0; i < result.size(); ++i) {
    ResultFrame frame;
    frame.t_capture = result[i].t_capture;
    frame.status = TrackingStatus::kTracking;
    frame.covariance = Matrix6d::Zero();
    if (i > 0) {
      // Off by 2 cm along x of the camera and 0.01 rad about its z, with sigmas of 1 cm and 0.01 rad:
      // 2^2 of the translation and 1^2 of the rotation, 5 together.
      Eigen::Isometry3d error = Eigen::Isometry3d::Identity();
      error.linear() = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      error.translation() = Eigen::Vector3d(0.02, 0, 0);
      result[i].T_world_left = result[i].T_world_left * error;
      frame.covariance = Matrix6d::Identity() * 1e-4;
    }
    frames.push_back(frame);
  }
  // Another world changes nothing: both are made equal at the first pose.
  for (ResultPose& pose : result) pose.T_world_left = SomewhereElse() * pose.T_world_left;
  const TrajectoryEvaluation evaluation = Evaluate(result, truth, frames);
  EXPECT_EQ(evaluation.covariance.count, 100);  // that of the first frame is zero
  EXPECT_NEAR(evaluation.covariance.mean_nees, 5.0, 1e-6);
  EXPECT_NEAR(evaluation.covariance.mean_nees_rotation, 1.0, 1e-6);
  EXPECT_NEAR(evaluation.covariance.mean_nees_translation, 4.0, 1e-6);
  EXPECT_NEAR(evaluation.covariance.share_within_95, 1.0, kExact);
}

TEST(TrajectoryEvaluationTest, SurvivesNoPoseAndARobotThatStands) {
  EXPECT_EQ(Evaluate({}, Curve()).coverage, 0.0);
  std::vector<TimedPose> still(50);
  for (int i = 0; i < 50; ++i) still[static_cast<std::size_t>(i)].t = TimeOf(i);
  const TrajectoryEvaluation evaluation = Evaluate(ResultOf(still), still);
  EXPECT_EQ(evaluation.coverage, 1.0);
  EXPECT_NEAR(evaluation.ate_rmse_m, 0.0, kExact);
  EXPECT_TRUE(evaluation.segments.empty());
}

}  // namespace
}  // namespace terrace
