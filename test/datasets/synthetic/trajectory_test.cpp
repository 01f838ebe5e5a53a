// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/trajectory.h"

#include <cmath>

#include <gtest/gtest.h>

#include "datasets/synthetic/sensors.h"
#include "datasets/synthetic/synthesis.h"
#include "test/datasets/synthetic/small_scene.h"

namespace terrace::synthetic {
namespace {

Trajectory Walk(const MotionPlan& plan) {
  return PlanMotion(
      plan, Mounting(), [](const Eigen::Vector3d& p) { return p.x() > 1.0 ? 0.15 : 0.0; }, 4);
}

MotionPlan WalkPlan() {
  MotionPlan plan;
  plan.path = {{0.0, 0.0}, {1.5, 0.0}, {2.0, 1.0}};
  return plan;
}

TEST(TrajectoryTest, APerfectImuIntegratesBackToThePoses) {
  const Trajectory trajectory = Walk(WalkPlan());
  BodyState state = trajectory.At(0.0);
  Eigen::Quaterniond q(state.T_world_body.rotation());
  Eigen::Vector3d v = state.v_world;
  Eigen::Vector3d p = state.T_world_body.translation();
  constexpr double kStep = 5e-4;
  const int steps = static_cast<int>(trajectory.duration_s() / kStep);
  for (int i = 0; i < steps; ++i) {
    // Midpoint rule.
    const ImuSample imu = PerfectImu(trajectory, (i + 0.5) * kStep, {});
    const Eigen::Vector3d half = 0.5 * kStep * imu.gyro;
    const Eigen::Quaterniond q_mid =
        q * Eigen::Quaterniond(1.0, 0.5 * half.x(), 0.5 * half.y(), 0.5 * half.z()).normalized();
    const Eigen::Vector3d a = q_mid * imu.accel + Eigen::Vector3d(0, 0, -9.81);
    p += kStep * (v + 0.5 * kStep * a);
    v += kStep * a;
    q = (q * Eigen::Quaterniond(1.0, half.x(), half.y(), half.z())).normalized();
  }
  state = trajectory.At(steps * kStep);
  EXPECT_LT((p - state.T_world_body.translation()).norm(), 1e-3);
  EXPECT_LT((v - state.v_world).norm(), 1e-3);
  EXPECT_LT(q.angularDistance(Eigen::Quaterniond(state.T_world_body.rotation())), 1e-4);
}

TEST(TrajectoryTest, VelocityIsTheDerivativeOfThePosition) {
  const Trajectory trajectory = Walk(WalkPlan());
  for (double t = 0.5; t < trajectory.duration_s() - 0.5; t += 0.037) {
    constexpr double kStep = 1e-4;
    const Eigen::Vector3d difference =
        (trajectory.PoseAt(t + kStep).translation() - trajectory.PoseAt(t - kStep).translation()) /
        (2.0 * kStep);
    EXPECT_LT((difference - trajectory.At(t).v_world).norm(), 1e-4) << t;
  }
}

TEST(TrajectoryTest, AWalkBouncesTwiceASecondAndClimbsWithTheGround) {
  const Trajectory trajectory = Walk(WalkPlan());
  const double height = Mounting().body_height_m;
  EXPECT_NEAR(trajectory.PoseAt(0.0).translation().z(), height, 1e-3);
  EXPECT_NEAR(trajectory.PoseAt(trajectory.duration_s()).translation().z(), height + 0.15, 2e-3);
  // At full pace, before the step: two maxima a second, 2 cm from top to bottom.
  double low = 1e9;
  double high = -1e9;
  int maxima = 0;
  for (double t = 1.4; t < 2.4; t += 0.001) {
    const double before = trajectory.At(t).v_world.z();
    const double after = trajectory.At(t + 0.001).v_world.z();
    const double z = trajectory.PoseAt(t).translation().z();
    low = std::min(low, z);
    high = std::max(high, z);
    // Jolts make small maxima of their own; those high up count.
    if (before > 0.0 && after <= 0.0 && z > height + 0.004) ++maxima;
  }
  EXPECT_NEAR(high - low, 0.022, 0.006);
  EXPECT_GE(maxima, 1);
  EXPECT_LE(maxima, 4);
  EXPECT_NEAR(static_cast<double>(trajectory.strikes_s().size()) / (trajectory.duration_s() - 2.4), 2.0, 0.5);
}

TEST(TrajectoryTest, StandingIsStillForAMinuteAndCreepingMovesTwoMillimetresASecond) {
  MotionPlan plan = WalkPlan();
  plan.kind = MotionKind::kStand;
  const Trajectory stand = Walk(plan);
  EXPECT_EQ(stand.duration_s(), 60.0);
  for (double t = 0.0; t < 60.0; t += 1.3) {
    EXPECT_LT((stand.PoseAt(t).translation() - stand.PoseAt(0.0).translation()).norm(), 5e-4);
  }
  plan.kind = MotionKind::kCreep;
  const Trajectory creep = Walk(plan);
  EXPECT_NEAR((creep.PoseAt(55.0).translation() - creep.PoseAt(5.0).translation()).norm(), 0.1, 5e-4);
}

TEST(TrajectoryTest, TurningOnTheSpotComesFullCircle) {
  MotionPlan plan = WalkPlan();
  plan.kind = MotionKind::kTurnOnSpot;
  const Trajectory turn = Walk(plan);
  double turned = 0.0;
  double yaw = 0.0;
  for (double t = 0.0; t <= turn.duration_s(); t += 0.02) {
    const Eigen::Matrix3d R = turn.PoseAt(t).rotation();
    const double now = std::atan2(R(1, 0), R(0, 0));
    turned += std::remainder(now - yaw, 2.0 * M_PI);
    yaw = now;
    EXPECT_LT(turn.PoseAt(t).translation().head<2>().norm(), 0.03);
  }
  EXPECT_NEAR(turned, 2.0 * M_PI, 0.05);
}

TEST(TrajectoryTest, TheBodyNeverEntersTheGroundOfAScene) {
  const Scene scene = SmallScene();
  const RayScene rays(scene);
  const Trajectory trajectory = PlanMotionIn(scene, rays, 1);
  for (double t = 0.0; t < trajectory.duration_s(); t += 0.1) {
    EXPECT_GT(trajectory.PoseAt(t).translation().z(), 0.25);
  }
}

}  // namespace
}  // namespace terrace::synthetic
