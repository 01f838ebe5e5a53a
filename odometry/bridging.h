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

  /// How far off at the worst, after one more step: how far to search.
  Matrix6d SearchCovariance(const Motion& predicted) const;

  double bridged_s() const { return bridged_s_; }
  /// Of the last pose against the last that was tracked, at the worst.
  const Matrix6d& covariance() const { return covariance_; }
  const Eigen::Isometry3d& T_world_seen() const { return T_world_seen_; }

 private:
  Eigen::Isometry3d T_world_seen_ = Eigen::Isometry3d::Identity();  ///< where the camera was tracked last
  Matrix6d seen_covariance_ = Matrix6d::Zero();                     ///< of that
  double bridged_s_ = 0.0;                                          ///< since
  Matrix6d covariance_ = Matrix6d::Zero();
};

}  // namespace terrace
