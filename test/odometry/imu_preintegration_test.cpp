// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_preintegration.h"

#include <functional>

#include <gtest/gtest.h>

#include "odometry/rotation.h"

namespace terrace {
namespace {

constexpr double kStep_s = 0.005;

Eigen::Vector3d Gyro(double t) { return {0.3 * std::sin(3 * t), 0.2, -0.4 * std::cos(2 * t)}; }
Eigen::Vector3d Accel(double t) { return {0.5 * std::sin(8 * t), -0.3, 9.8 + 2.0 * std::cos(12 * t)}; }

ImuPreintegration Integrated(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accel_bias) {
  ImuPreintegration sum({1e-3, 1e-4, 1e-2, 1e-3}, gyro_bias, accel_bias);
  for (int i = 0; i < 60; ++i) sum.Add(Gyro(i * kStep_s), Accel(i * kStep_s), kStep_s);
  return sum;
}

ImuState SomeState() {
  ImuState state;
  state.R_world_imu = ExpRotation({0.2, -0.1, 0.7});
  state.p_world << 1.0, 2.0, 0.5;
  state.v_world << 0.4, -0.1, 0.05;
  state.gyro_bias << 0.01, -0.02, 0.005;
  state.accel_bias << 0.1, 0.05, -0.08;
  return state;
}

/// Moves one of the 15 components, in the order of the columns of the derivatives.
ImuState Nudged(const ImuState& state, int component, double by) {
  ImuState out = state;
  const Eigen::Vector3d step = by * Eigen::Vector3d::Unit(component % 3);
  switch (component / 3) {
    case 0:
      out.R_world_imu = state.R_world_imu * ExpRotation(step);
      break;
    case 1:
      out.p_world += step;
      break;
    case 2:
      out.v_world += step;
      break;
    case 3:
      out.gyro_bias += step;
      break;
    default:
      out.accel_bias += step;
      break;
  }
  return out;
}

TEST(ImuPreintegrationTest, PredictsWhatStepByStepIntegrationGives) {
  const ImuState start = SomeState();
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  ImuState slow = start;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d turn = (Gyro(i * kStep_s) - start.gyro_bias) * kStep_s;
    const Eigen::Vector3d a =
        slow.R_world_imu * ExpRotation(0.5 * turn) * (Accel(i * kStep_s) - start.accel_bias) +
        kGravityMagnitude * down;
    slow.p_world += slow.v_world * kStep_s + 0.5 * a * kStep_s * kStep_s;
    slow.v_world += a * kStep_s;
    slow.R_world_imu = slow.R_world_imu * ExpRotation(turn);
  }
  const ImuState fast = Integrated(start.gyro_bias, start.accel_bias).Predict(start, down);
  EXPECT_LT((fast.p_world - slow.p_world).norm(), 1e-9);
  EXPECT_LT((fast.v_world - slow.v_world).norm(), 1e-9);
  EXPECT_LT(LogRotation(fast.R_world_imu.transpose() * slow.R_world_imu).norm(), 1e-9);

  // Biases that changed a little since the summing up are put in to first order.
  const ImuState corrected =
      Integrated(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()).Predict(start, down);
  EXPECT_LT((corrected.p_world - slow.p_world).norm(), 2e-4);
  EXPECT_LT(LogRotation(corrected.R_world_imu.transpose() * slow.R_world_imu).norm(), 2e-4);
}

TEST(ImuPreintegrationTest, DerivativesAreThoseOfDifferences) {
  const Eigen::Vector3d down = Eigen::Vector3d(0.02, -0.03, -1.0).normalized();
  const ImuPreintegration sum = Integrated({0.008, -0.015, 0.0}, {0.05, 0.0, 0.0});
  const ImuState start = SomeState();
  ImuState end = sum.Predict(start, down);
  end.R_world_imu = end.R_world_imu * ExpRotation({0.01, -0.02, 0.015});
  end.p_world += Eigen::Vector3d(0.01, 0.02, -0.01);
  end.v_world += Eigen::Vector3d(0.05, -0.05, 0.02);
  const auto l = sum.Linearize(start, end, down);
  constexpr double kH = 1e-6;
  for (int c = 0; c < 15; ++c) {
    const Eigen::Matrix<double, 15, 1> by_start = (sum.Linearize(Nudged(start, c, kH), end, down).residual -
                                                   sum.Linearize(Nudged(start, c, -kH), end, down).residual) /
                                                  (2 * kH);
    const Eigen::Matrix<double, 15, 1> by_end = (sum.Linearize(start, Nudged(end, c, kH), down).residual -
                                                 sum.Linearize(start, Nudged(end, c, -kH), down).residual) /
                                                (2 * kH);
    EXPECT_LT((by_start - l.by_start.col(c)).norm(), 2e-3) << "start, component " << c;
    EXPECT_LT((by_end - l.by_end.col(c)).norm(), 1e-5) << "end, component " << c;
  }
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3d nudge = kH * Eigen::Vector3d::Unit(c);
    const Eigen::Matrix<double, 15, 1> by_gravity =
        (sum.Linearize(start, end, down + nudge / kGravityMagnitude).residual -
         sum.Linearize(start, end, down - nudge / kGravityMagnitude).residual) /
        (2 * kH);
    EXPECT_LT((by_gravity - l.by_gravity.col(c)).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace terrace
