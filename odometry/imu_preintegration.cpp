// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_preintegration.h"

#include <algorithm>

#include <Eigen/Dense>

#include "odometry/rotation.h"

namespace terrace {
namespace {

/// A cheap IMU, for when nothing is known; and vibration makes every IMU worse than its data sheet.
constexpr double kVibration = 2.0;
ImuNoise Usable(const ImuNoise& given) {
  ImuNoise noise;
  noise.gyro_density = kVibration * (given.gyro_density > 0 ? given.gyro_density : 5e-4);
  noise.gyro_walk = kVibration * (given.gyro_walk > 0 ? given.gyro_walk : 5e-5);
  noise.accel_density = kVibration * (given.accel_density > 0 ? given.accel_density : 5e-3);
  noise.accel_walk = kVibration * (given.accel_walk > 0 ? given.accel_walk : 3e-3);
  return noise;
}

}  // namespace

ImuPreintegration::ImuPreintegration(const ImuNoise& noise, const Eigen::Vector3d& gyro_bias,
                                     const Eigen::Vector3d& accel_bias)
    : noise_(Usable(noise)), gyro_bias_(gyro_bias), accel_bias_(accel_bias) {}

void ImuPreintegration::Add(const Eigen::Vector3d& gyro, const Eigen::Vector3d& accel, double dt) {
  const Eigen::Vector3d turn = (gyro - gyro_bias_) * dt;
  const Eigen::Vector3d a = accel - accel_bias_;
  const Eigen::Matrix3d step = ExpRotation(turn);
  const Eigen::Matrix3d Jr = RightJacobian(turn);
  const Eigen::Matrix3d R_half = R_ * ExpRotation(0.5 * turn);  // in the middle of the stretch
  const Eigen::Matrix3d R_a = R_half * Skew(a);

  Matrix9d A = Matrix9d::Identity();
  A.block<3, 3>(0, 0) = step.transpose();
  A.block<3, 3>(3, 0) = -R_a * dt;
  A.block<3, 3>(6, 0) = -0.5 * R_a * dt * dt;
  A.block<3, 3>(6, 3) = Eigen::Matrix3d::Identity() * dt;
  Eigen::Matrix<double, 9, 3> by_gyro = Eigen::Matrix<double, 9, 3>::Zero();
  by_gyro.topRows<3>() = Jr * dt;
  Eigen::Matrix<double, 9, 3> by_accel = Eigen::Matrix<double, 9, 3>::Zero();
  by_accel.middleRows<3>(3) = R_half * dt;
  by_accel.bottomRows<3>() = 0.5 * R_half * dt * dt;
  covariance_ = (A * covariance_ * A.transpose()).eval();
  covariance_ += by_gyro * by_gyro.transpose() * (noise_.gyro_density * noise_.gyro_density / dt);
  covariance_ += by_accel * by_accel.transpose() * (noise_.accel_density * noise_.accel_density / dt);

  p_by_accel_ += v_by_accel_ * dt - 0.5 * R_half * dt * dt;
  p_by_gyro_ += v_by_gyro_ * dt - 0.5 * R_a * R_by_gyro_ * dt * dt;
  v_by_accel_ -= R_half * dt;
  v_by_gyro_ -= R_a * R_by_gyro_ * dt;
  R_by_gyro_ = step.transpose() * R_by_gyro_ - Jr * dt;

  p_ += v_ * dt + 0.5 * R_half * a * dt * dt;
  v_ += R_half * a * dt;
  R_ = Normalized(R_ * step);
  dt_s_ += dt;
}

ImuState ImuPreintegration::Predict(const ImuState& start, const Eigen::Vector3d& down_world) const {
  const Eigen::Vector3d g = kGravityMagnitude * down_world;
  const Eigen::Vector3d dbg = start.gyro_bias - gyro_bias_;
  const Eigen::Vector3d dba = start.accel_bias - accel_bias_;
  ImuState end = start;
  end.R_world_imu = start.R_world_imu * R_ * ExpRotation(R_by_gyro_ * dbg);
  end.v_world = start.v_world + g * dt_s_ + start.R_world_imu * (v_ + v_by_gyro_ * dbg + v_by_accel_ * dba);
  end.p_world = start.p_world + start.v_world * dt_s_ + 0.5 * g * dt_s_ * dt_s_ +
                start.R_world_imu * (p_ + p_by_gyro_ * dbg + p_by_accel_ * dba);
  return end;
}

ImuPreintegration::Linearization ImuPreintegration::Linearize(const ImuState& i, const ImuState& j,
                                                              const Eigen::Vector3d& down_world) const {
  const Eigen::Vector3d g = kGravityMagnitude * down_world;
  const Eigen::Vector3d dbg = i.gyro_bias - gyro_bias_;
  const Eigen::Vector3d dba = i.accel_bias - accel_bias_;
  const double dt = dt_s_;
  const Eigen::Matrix3d Rt = i.R_world_imu.transpose();
  const Eigen::Vector3d turn = R_by_gyro_ * dbg;
  const Eigen::Vector3d r_R = LogRotation((R_ * ExpRotation(turn)).transpose() * Rt * j.R_world_imu);
  const Eigen::Vector3d dv = Rt * (j.v_world - i.v_world - g * dt);
  const Eigen::Vector3d dp = Rt * (j.p_world - i.p_world - i.v_world * dt - 0.5 * g * dt * dt);

  Linearization out;
  out.residual << r_R, dv - (v_ + v_by_gyro_ * dbg + v_by_accel_ * dba),
      dp - (p_ + p_by_gyro_ * dbg + p_by_accel_ * dba), j.gyro_bias - i.gyro_bias,
      j.accel_bias - i.accel_bias;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d Jr_inverse = InverseRightJacobian(r_R);
  auto& A = out.by_start;
  A.setZero();
  A.block<3, 3>(0, 0) = -Jr_inverse * j.R_world_imu.transpose() * i.R_world_imu;
  A.block<3, 3>(0, 9) = -Jr_inverse * ExpRotation(r_R).transpose() * RightJacobian(turn) * R_by_gyro_;
  A.block<3, 3>(3, 0) = Skew(dv);
  A.block<3, 3>(3, 6) = -Rt;
  A.block<3, 3>(3, 9) = -v_by_gyro_;
  A.block<3, 3>(3, 12) = -v_by_accel_;
  A.block<3, 3>(6, 0) = Skew(dp);
  A.block<3, 3>(6, 3) = -Rt;
  A.block<3, 3>(6, 6) = -Rt * dt;
  A.block<3, 3>(6, 9) = -p_by_gyro_;
  A.block<3, 3>(6, 12) = -p_by_accel_;
  A.block<3, 3>(9, 9) = -I;
  A.block<3, 3>(12, 12) = -I;
  auto& B = out.by_end;
  B.setZero();
  B.block<3, 3>(0, 0) = Jr_inverse;
  B.block<3, 3>(3, 6) = Rt;
  B.block<3, 3>(6, 3) = Rt;
  B.block<3, 3>(9, 9) = I;
  B.block<3, 3>(12, 12) = I;
  out.by_gravity.setZero();
  out.by_gravity.middleRows<3>(3) = -Rt * dt;
  out.by_gravity.middleRows<3>(6) = -0.5 * Rt * dt * dt;
  return out;
}

Eigen::Matrix<double, 15, 15> ImuPreintegration::Information() const {
  // What sampling and integration leave open even in a short stretch.
  constexpr double kRotationFloor = 1e-4;
  constexpr double kVelocityFloor = 2e-3;
  constexpr double kPositionFloor = 1e-4;
  Eigen::Matrix<double, 15, 15> covariance = Eigen::Matrix<double, 15, 15>::Zero();
  covariance.topLeftCorner<9, 9>() = covariance_;
  covariance.diagonal().segment<3>(0).array() += kRotationFloor * kRotationFloor;
  covariance.diagonal().segment<3>(3).array() += kVelocityFloor * kVelocityFloor;
  covariance.diagonal().segment<3>(6).array() += kPositionFloor * kPositionFloor;
  const double dt = std::max(dt_s_, 1e-3);
  covariance.diagonal().segment<3>(9).array() += noise_.gyro_walk * noise_.gyro_walk * dt;
  covariance.diagonal().segment<3>(12).array() += noise_.accel_walk * noise_.accel_walk * dt;
  return covariance.ldlt().solve(Eigen::Matrix<double, 15, 15>::Identity());
}

}  // namespace terrace
