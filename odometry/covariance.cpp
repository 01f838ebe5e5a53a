// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/covariance.h"

#include <Eigen/Dense>

#include "odometry/rotation.h"

namespace terrace {
namespace {

/// Derivative of the error of T_a_c = T_a_b * T_b_c (in c) by the error of T_a_b (in b).
Matrix6d ErrorTransport(const Eigen::Isometry3d& T_b_c) {
  const Eigen::Matrix3d R_c_b = T_b_c.linear().transpose();
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = R_c_b;
  m.bottomRightCorner<3, 3>() = R_c_b;
  m.bottomLeftCorner<3, 3>() = -R_c_b * Skew(T_b_c.translation());
  return m;
}

}  // namespace

Matrix6d TransportCovariance(const Eigen::Isometry3d& T_b_c, const Matrix6d& covariance) {
  const Matrix6d transport = ErrorTransport(T_b_c);
  return transport * covariance * transport.transpose();
}

Matrix6d Inverse(const Matrix6d& m) { return m.inverse(); }

double Chi2(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

std::optional<Vector6d> SolvePositive(const Matrix6d& H, const Vector6d& g) {
  const Eigen::LDLT<Matrix6d> solver(H);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  return solver.solve(g);
}

}  // namespace terrace
