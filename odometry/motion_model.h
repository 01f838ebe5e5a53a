// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "odometry/imu_preintegration.h"
#include "odometry/leg_follower.h"
#include "odometry/odometry_config.h"
#include "odometry/window.h"
#include "odometry/window_optimizer.h"

namespace terrace {

/// A motion from the last pose, believed before the images are looked at.
struct Motion {
  double dt_s = 0.0;
  Eigen::Isometry3d T_last_left = Eigen::Isometry3d::Identity();
  /// What it may be wrong by at the worst, at a foot strike: how far to search.
  Matrix6d covariance = Matrix6d::Zero();
  Eigen::Vector3d velocity_world = Eigen::Vector3d::Zero();  ///< of the IMU, then
  bool by_legs = false;
  bool by_imu = false;
};

/// How the camera moves while nobody looks: by the IMU, else by the legs, else as it has moved so far.
class MotionModel {
 public:
  MotionModel(const OdometryConfig& config, const Mounting& mounting)
      : config_(config), mounting_(mounting), legs_(config.max_speed_mps) {}

  /// Takes in what the sensors said since the last pose.
  /// @param last  none: the world begins at t_capture
  /// @param biases  of the IMU, as the newest keyframe knows them
  void Read(const SensorSamples& samples, const std::optional<PoseEstimate>& last, Timestamp t_capture,
            const KeyframeState& biases);
  Motion Predict(const PoseEstimate& last, Timestamp t_capture, const KeyframeState& biases,
                 const Gravity& gravity) const;

  /// What bridging is wrong by as a rule, this long after the last pose that the images have shown.
  /// @param known  of the IMU, at that pose
  Matrix6d DriftCovariance(double bridged_s, const ImuSigmas& known, const Gravity& gravity) const;

  /// The images have shown where the camera came to.
  void Correct(const PoseEstimate& last, const PoseEstimate& pose, const Motion& predicted,
               const KeyframeState& biases, const Gravity& gravity);
  /// They have not.
  void Bridge(const Motion& predicted, const Gravity& gravity);
  /// They have not for so long that nothing is known about velocities any more.
  void Lose();
  /// The clock was set.
  void LoseTime() { newest_sample_.reset(); }
  /// Another world begins. What is known about the IMU itself stays.
  void Restart();
  /// What the refined window says about a keyframe at the last pose.
  void Refine(const KeyframeState& newest) { imu_velocity_world_ = newest.velocity_world; }

  /// What the IMU knows of a new keyframe at the last pose.
  void FillKeyframe(const KeyframeState& before, Keyframe& keyframe) const;
  /// Sums the IMU up anew, from a keyframe at the last pose.
  void RestartKeyframe();

  bool imu_in_use() const { return imu_in_use_; }
  /// True when samples have come that may be used.
  bool has_imu() const { return newest_sample_.has_value() && !imu_refused_; }
  void UseImu() { imu_in_use_ = true; }
  void RefuseImu();
  bool imu_refused() const { return imu_refused_; }
  const Eigen::Vector3d& imu_velocity_world() const { return imu_velocity_world_; }

  LegFollower& legs() { return legs_; }

 private:
  void IntegrateImu(const SensorSamples& samples, const std::optional<PoseEstimate>& last,
                    Timestamp t_capture, const KeyframeState& biases);
  void CorrectImuVelocity(const PoseEstimate& last, const PoseEstimate& pose, const Motion& predicted,
                          const KeyframeState& biases, const Gravity& gravity);
  ImuState ImuAt(const Eigen::Isometry3d& T_world_left, const KeyframeState& biases) const;

  OdometryConfig config_;
  Mounting mounting_;

  Eigen::Vector3d velocity_world_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_velocity_world_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rate_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_rotation_rate_ = Eigen::Vector3d::Zero();

  bool imu_in_use_ = false;
  bool imu_refused_ = false;
  std::optional<ImuSample> newest_sample_;
  std::optional<ImuPreintegration> imu_since_last_;
  std::optional<ImuPreintegration> imu_since_keyframe_;
  bool imu_gapless_ = false;          ///< since the last frame
  bool keyframe_imu_gapless_ = true;  ///< since the newest keyframe
  Eigen::Vector3d imu_velocity_world_ = Eigen::Vector3d::Zero();
  double imu_velocity_sigma_ = 1.0;  ///< m/s

  LegFollower legs_;
};

}  // namespace terrace
