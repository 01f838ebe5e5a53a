// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/geometry.h"
#include "odometry/window.h"

namespace terrace {

/// A known point and where it was measured. The point is homogeneous, p_world = point / inverse_depth.
struct PoseConstraint {
  Eigen::Vector3d point_world = Eigen::Vector3d::Zero();
  double inverse_depth = 1.0;
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
  /// Makes residuals (u, v, disparity) independent with unit variance; rows of zeros: not measured.
  Eigen::Matrix3d whitening = Eigen::Matrix3d::Identity();
  /// Weight when hypotheses compete: what has long stood still is believed before what is new.
  double trust = 1.0;
};

/// What was known about the pose before looking.
struct PosePrior {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< rotation, translation; left frame
};

struct PoseSolution {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< rotation, translation; left frame
  std::vector<bool> inlier;                 ///< of each constraint
  std::vector<double> chi2;                 ///< of each constraint
  int num_inliers = 0;
  double rms_px = 0.0;     ///< of the inliers, over u and v
  double mean_chi2 = 0.0;  ///< of the inliers, per measured component
};

/// Robust pose from points seen in both cameras: samples of three points compete with the prior, then
/// weighted Gauss-Newton over all that agree. Same constraints and seed, same pose.
PoseSolution SolvePose(const std::vector<PoseConstraint>& constraints, const PosePrior& prior,
                       const StereoCamera& camera, std::uint32_t seed);

/// The whitening for a measurement of a landmark whose inverse depth is itself uncertain.
Eigen::Matrix3d Whitening(const StereoMeasurement& measurement, const Eigen::Vector3d& uvd_by_inverse_depth,
                          double inverse_depth_sigma);

}  // namespace terrace
