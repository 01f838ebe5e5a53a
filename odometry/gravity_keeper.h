// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/Core>

#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "odometry/odometry_config.h"

namespace terrace {

/// A better "up" than the odometry knows, from floors and treads.
struct GravityHint {
  FrameId frame_id = 0;
  Eigen::Vector3d down_world = -Eigen::Vector3d::UnitZ();
  double sigma_rad = 0.0;
};

/// Knows where down is in the world: by the best source there is, as DESIGN.md orders them.
class GravityKeeper {
 public:
  GravityKeeper(const OdometryConfig& config, const Mounting& mounting)
      : config_(config), mounting_(mounting) {}

  const Gravity& gravity() const { return gravity_; }

  /// A world has been laid.
  /// @param without_imu  what would be known without the IMU
  /// @param down_if_level  where down is in the world if the body stood level when it was laid
  void Start(const Gravity& gravity, const Gravity& without_imu,
             const Eigen::Vector3d& down_if_level = -Eigen::Vector3d::UnitZ()) {
    gravity_ = gravity;
    without_imu_ = without_imu;
    down_if_level_ = down_if_level;
    num_contradictions_ = num_agreed_ = num_apart_ = 0;
    attitude_refused_ = legs_refused_ = false;
    followed_ = Followed::kNobody;
  }
  /// From now on the window knows, by an IMU.
  void UseImu() { gravity_.source = GravitySource::kImu; }
  /// What the window has made of it.
  void Refine(const Eigen::Vector3d& down_world, double sigma_rad);
  /// The IMU was wrong, and with it what it said about up: as if there had been none.
  void RefuseImu() { gravity_ = without_imu_; }
  /// Something is wrong with the images: up is not known better than this.
  void Doubt(double sigma_rad) { gravity_.sigma_rad = std::max(gravity_.sigma_rad, sigma_rad); }
  /// Floors and treads; an IMU or the robot's own attitude knows better.
  void Take(const GravityHint& hint);
  /// The robot's own attitude, at a tracked frame.
  void FollowAttitude(const SensorSamples& samples, const PoseEstimate& pose);

  /// What the user should be told, once each; none: nothing new.
  std::optional<std::string> TakeWarning() { return std::exchange(warning_, std::nullopt); }

 private:
  /// Whose roll and pitch have been followed since the world was laid.
  enum class Followed { kNobody, kAttitude, kLegs };
  struct Down {
    Eigen::Vector3d down_world;
    double sigma_rad = 0.0;
  };
  Down DownSaidBy(const BodyPrior& prior, double least_sigma_rad, const PoseEstimate& pose) const;
  void Follow(const Down& said, Followed by);
  bool Believes(const Down& said);
  void Compare(const Down& by_attitude, const Down& by_legs);

  OdometryConfig config_;
  Mounting mounting_;
  Gravity gravity_;
  Gravity without_imu_;
  int num_contradictions_ = 0;  ///< readings of the attitude that cannot be, less those that can
  int num_agreed_ = 0;          ///< readings in a row, since the attitude was refused
  int num_apart_ = 0;           ///< frames in which attitude and legs exclude each other, less the others
  bool attitude_refused_ = false;
  bool legs_refused_ = false;  ///< their roll and pitch
  Eigen::Vector3d down_if_level_ = -Eigen::Vector3d::UnitZ();
  Followed followed_ = Followed::kNobody;
  std::optional<std::string> warning_;
};

}  // namespace terrace
