// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_moments.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace terrace {

void PlaneMoments::Add(double w, const Eigen::Vector3d& p) {
  weight += w;
  sum += w * p;
  sum_outer += w * p * p.transpose();
}

void PlaneMoments::Add(const PlaneMoments& other, const Eigen::Vector3d& shift) {
  // sum w (p + s)(p + s)^T = sum w p p^T + (sum w p) s^T + s (sum w p)^T + w s s^T
  weight += other.weight;
  sum += other.sum + other.weight * shift;
  sum_outer += other.sum_outer + other.sum * shift.transpose() + shift * other.sum.transpose() +
               other.weight * shift * shift.transpose();
}

Eigen::Matrix3d PlaneMoments::Covariance() const {
  const Eigen::Vector3d mean = Mean();
  return sum_outer / weight - mean * mean.transpose();
}

Plane PlaneMoments::Fit(const Eigen::Vector3d& towards) const {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(Covariance());
  Plane plane;
  plane.normal = solver.eigenvectors().col(0).normalized();
  if (plane.normal.dot(towards) < 0.0) plane.normal = -plane.normal;
  plane.offset_m = plane.normal.dot(Mean());
  return plane;
}

double PlaneMoments::MeanSquaredDistance(const Plane& plane) const {
  const double distance = plane.SignedDistance(Mean());
  return std::max(0.0, plane.normal.dot(Covariance() * plane.normal)) + distance * distance;
}

}  // namespace terrace
