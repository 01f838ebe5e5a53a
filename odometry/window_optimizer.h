// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/geometry.h"
#include "odometry/window.h"

namespace terrace {

/// Standard deviations along any axis.
struct ImuSigmas {
  double velocity = 0.0;    ///< m/s
  double gyro_bias = 0.0;   ///< rad/s
  double accel_bias = 0.0;  ///< m/s^2

  /// Of an IMU whose images begin just now.
  static ImuSigmas AtFirst() { return {1.0, 0.02, 0.15}; }
};

/// Refines the keyframes and landmarks of a window together: Levenberg-Marquardt over reprojection in both
/// cameras, preintegrated IMU factors with biases and the direction of gravity, and a prior that stands for
/// all that has left the window. Every landmark has one unknown, its inverse depth, and is eliminated by hand
/// before the poses are solved for: the problem shrinks to the poses, and the reduced matrix
/// gives covariance and marginalisation for nothing.
class WindowOptimizer {
 public:
  /// @param T_left_imu  none: without an IMU
  WindowOptimizer(const StereoCamera& camera, const std::optional<Eigen::Isometry3d>& T_left_imu);

  /// Starts anew with one keyframe that is known this well. Forgets all others.
  /// @param imu  how well what the keyframe says of an IMU is known
  void Start(const Keyframe& first, const Matrix6d& pose_covariance, double gravity_sigma_rad,
             const ImuSigmas& imu = ImuSigmas::AtFirst());

  /// Refines everything in the window and the direction of gravity.
  /// @param noise_scale  variance of residuals over what the measurements claim
  void Optimize(Window& window, Eigen::Vector3d& down_world, double noise_scale, int max_iterations);

  /// Takes the oldest keyframe and the landmarks it hosts out of the window; what they said stays as a prior.
  void DropOldest(Window& window, const Eigen::Vector3d& down_world, double noise_scale);

  /// Of the newest keyframe against the first pose ever, after Optimize.
  const Matrix6d& newest_covariance() const { return newest_covariance_; }
  /// How well an IMU's state at the newest keyframe is known, per axis: zeros without an IMU.
  const ImuSigmas& newest_imu_sigmas() const { return newest_imu_sigmas_; }
  double gravity_sigma_rad() const { return gravity_sigma_rad_; }

 private:
  struct System;
  struct Point;

  int Dimension(std::size_t num_keyframes) const {
    return static_cast<int>(num_keyframes) * state_size_ + gravity_size_;
  }
  ImuState ImuOf(const KeyframeState& state) const;
  /// Normal equations over keyframe states and gravity, landmarks eliminated. only_host >= 0: nothing but
  /// what involves that keyframe.
  double Build(const Window& window, const Eigen::Vector3d& down_world, double noise_scale, bool only_oldest,
               System* system) const;
  void AddPrior(const Window& window, const Eigen::Vector3d& down_world, System* system, double* cost) const;
  void AddImu(const Window& window, const Eigen::Vector3d& down_world, bool only_oldest, System* system,
              double* cost) const;
  double AddLandmarks(const Window& window, double noise_scale, bool only_oldest, System* system) const;
  Eigen::VectorXd PriorStep(const Window& window, const Eigen::Vector3d& down_world) const;

  StereoCamera camera_;
  std::optional<Eigen::Isometry3d> T_left_imu_;
  int state_size_ = 6;    ///< pose; with an IMU: pose, velocity, biases
  int gravity_size_ = 0;  ///< tilts about two axes

  /// cost = 0.5 x^T H x + g^T x, with x the step from the states below; over keyframe states, then gravity.
  Eigen::MatrixXd prior_H_;
  Eigen::VectorXd prior_g_;
  std::vector<KeyframeState> prior_states_;
  Eigen::Vector3d prior_down_ = -Eigen::Vector3d::UnitZ();

  Matrix6d newest_covariance_ = Matrix6d::Zero();
  ImuSigmas newest_imu_sigmas_;
  double gravity_sigma_rad_ = 0.0;
};

}  // namespace terrace
