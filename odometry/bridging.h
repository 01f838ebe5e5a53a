// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "odometry/motion_model.h"

namespace terrace {

/// Carries the pose over frames whose images show nothing, and knows how far off it may be by then.
class Bridging {
 public:
  /// The images have shown where the camera is.
  void See(const PoseEstimate& pose);

  /// Goes on from the last pose by what was predicted: pose and covariances, the rest is the caller's.
  /// @param drift_after  covariance of what bridging is wrong by as a rule, by seconds
  PoseEstimate Extend(const PoseEstimate& last, const Motion& predicted,
                      const std::function<Matrix6d(double)>& drift_after);
  /// Stays where it is, while nothing is known any more.
  PoseEstimate Hold(const PoseEstimate& last, double dt_s);
  /// Nothing is known about the time since the last pose: a new clock.
  void LoseTime();

  /// True when the place is one where the camera can have come to since it was tracked, at the worst.
  bool CanReach(const Eigen::Isometry3d& T_world_left, const Eigen::Isometry3d& bridged_T_world_left) const;
  /// How far off at the worst, after one more step: how far to search.
  Matrix6d SearchCovariance(const Motion& predicted) const;

  /// The same as a rule: what contradicts it is another motion.
  Matrix6d ExpectedCovariance(const Motion& predicted) const;

  double bridged_s() const { return bridged_s_; }
  const Eigen::Isometry3d& T_world_seen() const { return T_world_seen_; }

 private:
  Eigen::Isometry3d T_world_seen_ = Eigen::Isometry3d::Identity();  ///< where the camera was tracked last
  Matrix6d seen_covariance_ = Matrix6d::Zero();                     ///< of that
  double bridged_s_ = 0.0;                                          ///< since
  int num_steps_ = 0;                                               ///< since
  Matrix6d covariance_ = Matrix6d::Zero();  ///< of the last pose against that, at the worst
  Matrix6d drift_ = Matrix6d::Zero();       ///< the same, as a rule
};

}  // namespace terrace
