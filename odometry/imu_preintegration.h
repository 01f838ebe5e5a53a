// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/sensor_frame.h"

namespace terrace {

constexpr double kGravityMagnitude = 9.81;  ///< m/s^2; what is left goes into the accelerometer's bias

/// Pose and motion of an IMU.
struct ImuState {
  Eigen::Matrix3d R_world_imu = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
};

/// IMU samples between two moments, summed up so that pose and velocity at the start, and small changes of
/// the biases, can be put in later (Forster et al., On-Manifold Preintegration, 2017).
class ImuPreintegration {
 public:
  using Matrix9d = Eigen::Matrix<double, 9, 9>;

  ImuPreintegration() = default;
  ImuPreintegration(const ImuNoise& noise, const Eigen::Vector3d& gyro_bias,
                    const Eigen::Vector3d& accel_bias);

  /// Adds a stretch in which both readings were constant.
  void Add(const Eigen::Vector3d& gyro, const Eigen::Vector3d& accel, double dt_s);

  double dt_s() const { return dt_s_; }
  const Matrix9d& covariance() const { return covariance_; }  ///< rotation, velocity, position
  ImuState Predict(const ImuState& start, const Eigen::Vector3d& down_world) const;

  /// Residual (rotation, velocity, position, gyro bias, accelerometer bias) of two states and its
  /// derivatives. Columns: rotation (in the IMU), position (in the world), velocity, gyro bias, accelerometer
  /// bias.
  struct Linearization {
    Eigen::Matrix<double, 15, 1> residual;
    Eigen::Matrix<double, 15, 15> by_start;
    Eigen::Matrix<double, 15, 15> by_end;
    Eigen::Matrix<double, 15, 3> by_gravity;  ///< by the gravity vector [m/s^2]
  };
  Linearization Linearize(const ImuState& start, const ImuState& end,
                          const Eigen::Vector3d& down_world) const;
  /// Inverse covariance of the residual.
  Eigen::Matrix<double, 15, 15> Information() const;

 private:
  ImuNoise noise_;
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_ = Eigen::Vector3d::Zero();
  double dt_s_ = 0.0;
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_by_gyro_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d v_by_gyro_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d v_by_accel_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d p_by_gyro_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d p_by_accel_ = Eigen::Matrix3d::Zero();
  Matrix9d covariance_ = Matrix9d::Zero();
};

}  // namespace terrace
