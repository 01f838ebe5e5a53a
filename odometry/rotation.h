// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

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
inline Eigen::Matrix3d ExpRotation(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-9) return Eigen::Matrix3d::Identity() + Skew(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

inline Eigen::Vector3d LogRotation(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

/// Jr with Exp(phi + delta) = Exp(phi) * Exp(Jr * delta) to first order.
inline Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d S = Skew(phi);
  if (angle < 1e-5) return Eigen::Matrix3d::Identity() - 0.5 * S + S * S / 6.0;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / a2 * S +
         (angle - std::sin(angle)) / (a2 * angle) * S * S;
}
inline Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& phi) {
  return RightJacobian(phi).inverse();
}

/// Moves a pose by a small step in its own frame: rotation [rad], then translation [m].
inline Eigen::Isometry3d Perturb(const Eigen::Isometry3d& T, const Vector6d& step) {
  Eigen::Isometry3d out;
  out.linear() = Eigen::Quaterniond(T.linear() * ExpRotation(step.head<3>())).normalized().toRotationMatrix();
  out.translation() = T.translation() + T.linear() * step.tail<3>();
  out.makeAffine();
  return out;
}

/// The step with Perturb(from, step) = to.
inline Vector6d StepBetween(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::Isometry3d delta = from.inverse() * to;
  Vector6d step;
  step << LogRotation(delta.linear()), delta.translation();
  return step;
}

/// Derivative of the error of T_a_c = T_a_b * T_b_c (in c) by the error of T_a_b (in b).
inline Matrix6d ErrorTransport(const Eigen::Isometry3d& T_b_c) {
  const Eigen::Matrix3d R_c_b = T_b_c.linear().transpose();
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = R_c_b;
  m.bottomRightCorner<3, 3>() = R_c_b;
  m.bottomLeftCorner<3, 3>() = -R_c_b * Skew(T_b_c.translation());
  return m;
}

}  // namespace terrace
