// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/geometry.h"

namespace terrace {

/// Weighted sums over pieces of one surface, each weighed by what it says about the surface along the normal.
/// Sums of sums are exact: the plane of many patches is the plane of all their points, never an average of
/// normals.
struct PlaneMoments {
  double weight = 0.0;                                  ///< sum of 1 / variance along the normal [1/m^2]
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();        ///< weight * p, relative to an origin the owner knows
  Eigen::Matrix3d sum_outer = Eigen::Matrix3d::Zero();  ///< weight * p * p^T

  void Add(double w, const Eigen::Vector3d& p);
  /// Adds sums whose origin lies at `shift` from ours.
  void Add(const PlaneMoments& other, const Eigen::Vector3d& shift);

  Eigen::Vector3d Mean() const { return sum / weight; }
  Eigen::Matrix3d Covariance() const;
  /// The plane of least weighted squared distance, its normal on the side of `towards`. Its offset is
  /// relative to the origin of the sums.
  Plane Fit(const Eigen::Vector3d& towards) const;
  /// Weighted mean of the squared distances to a plane given relative to the same origin.
  double MeanSquaredDistance(const Plane& plane) const;
};

}  // namespace terrace
