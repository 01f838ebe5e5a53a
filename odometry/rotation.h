// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"

namespace terrace {

/// The matrix of the cross product: Skew(a) * b = a x b.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// Rotation by a vector: axis times angle [rad].
Eigen::Matrix3d ExpRotation(const Eigen::Vector3d& phi);
Eigen::Vector3d LogRotation(const Eigen::Matrix3d& R);

/// Of a rotation: takes away what rounding has done to it.
Eigen::Matrix3d Normalized(const Eigen::Matrix3d& R);

/// Jr with Exp(phi + delta) = Exp(phi) * Exp(Jr * delta) to first order.
Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& phi);
Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& phi);

/// T_a_b * T_b_c with a rotation that stays one however long the chain. Inverting a pose transposes its
/// rotation, so that rounding would otherwise grow with every link.
Eigen::Isometry3d Chained(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_b_c);

/// Moves a pose by a small step in its own frame: rotation [rad], then translation [m].
Eigen::Isometry3d Perturb(const Eigen::Isometry3d& T, const Vector6d& step);

/// The step with Perturb(from, step) = to.
Vector6d StepBetween(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);

}  // namespace terrace
