// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/rotation.h"

#include <cmath>

#include <Eigen/Dense>

namespace terrace {

Eigen::Matrix3d ExpRotation(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-9) return Eigen::Matrix3d::Identity() + Skew(phi);
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

Eigen::Vector3d LogRotation(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

Eigen::Matrix3d Normalized(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d S = Skew(phi);
  if (angle < 1e-5) return Eigen::Matrix3d::Identity() - 0.5 * S + S * S / 6.0;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / a2 * S +
         (angle - std::sin(angle)) / (a2 * angle) * S * S;
}

Eigen::Matrix3d InverseRightJacobian(const Eigen::Vector3d& phi) { return RightJacobian(phi).inverse(); }

Eigen::Isometry3d Chained(const Eigen::Isometry3d& T_a_b, const Eigen::Isometry3d& T_b_c) {
  Eigen::Isometry3d T_a_c = T_a_b * T_b_c;
  T_a_c.linear() = Normalized(T_a_c.linear());
  return T_a_c;
}

Eigen::Isometry3d Perturb(const Eigen::Isometry3d& T, const Vector6d& step) {
  Eigen::Isometry3d out;
  out.linear() = Normalized(T.linear() * ExpRotation(step.head<3>()));
  out.translation() = T.translation() + T.linear() * step.tail<3>();
  out.makeAffine();
  return out;
}

Vector6d StepBetween(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::Isometry3d delta = from.inverse() * to;
  Vector6d step;
  step << LogRotation(delta.linear()), delta.translation();
  return step;
}

}  // namespace terrace
