// SPDX-License-Identifier: BSD-3-Clause
#include "client/pose_history.h"

#include <cmath>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// Turning left at 1 rad/s while walking along x at 2 m/s.
BodyPose PoseAt(double t_s, int epoch = 0) {
  BodyPose pose;
  pose.t_capture = {static_cast<std::int64_t>(std::llround(1e9 * t_s))};
  pose.epoch = epoch;
  pose.status = TrackingStatus::kTracking;
  pose.T_world_body = Eigen::Isometry3d::Identity();
  pose.T_world_body->linear() = Eigen::AngleAxisd(t_s, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.T_world_body->translation().x() = 2.0 * t_s;
  return pose;
}

TEST(PoseHistoryTest, KnowsThePoseBetweenTwoWhateverTheOrderOfArrival) {
  PoseHistory history;
  for (const double t : {1.0, 1.2, 1.1, 1.1, 1.3}) history.Add(PoseAt(t));
  const auto pose = history.At({1'150'000'000});
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->T_world_body->isApprox(*PoseAt(1.15).T_world_body, 1e-9));
  EXPECT_EQ(pose->t_capture.ns, 1'150'000'000);
  EXPECT_TRUE(history.At({1'300'000'000}));
  EXPECT_FALSE(history.At({1'310'000'000})) << "the future is not known";
  EXPECT_FALSE(history.At({990'000'000}));
}

TEST(PoseHistoryTest, SaysNothingAcrossAGapOrWhileLost) {
  PoseHistory history;
  history.Add(PoseAt(1.0));
  history.Add(PoseAt(1.6));
  EXPECT_FALSE(history.At({1'300'000'000})) << "too far apart";
  BodyPose lost = PoseAt(1.7);
  lost.status = TrackingStatus::kLost;
  lost.T_world_body.reset();
  history.Add(lost);
  history.Add(PoseAt(1.8));
  EXPECT_FALSE(history.At({1'650'000'000}));
  EXPECT_FALSE(history.At({1'700'000'000}));
  EXPECT_FALSE(history.At({1'750'000'000}));
}

TEST(PoseHistoryTest, BetweenTrackingAndBridgingItIsBridgingWithTheLargerCovariance) {
  PoseHistory history;
  BodyPose bridging = PoseAt(1.0);
  bridging.status = TrackingStatus::kBridging;
  bridging.covariance = 4.0 * Matrix6d::Identity();
  history.Add(bridging);
  history.Add(PoseAt(1.1));
  EXPECT_EQ(history.At({1'050'000'000})->status, TrackingStatus::kBridging);
  EXPECT_DOUBLE_EQ(history.At({1'050'000'000})->covariance(0, 0), 4.0);
}

TEST(PoseHistoryTest, ForgetsPosesOfAnotherWorld) {
  PoseHistory history;
  history.Add(PoseAt(1.0));
  history.Add(PoseAt(1.1, 1));
  history.Add(PoseAt(1.05, 0));
  EXPECT_FALSE(history.At({1'050'000'000}));
  EXPECT_TRUE(history.At({1'100'000'000}));
  EXPECT_EQ(history.newest()->epoch, 1);
}

}  // namespace
}  // namespace terrace
