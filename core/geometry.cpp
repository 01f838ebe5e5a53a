// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry.h"

#include <cmath>

namespace terrace {

PlaneAxes AxesOf(const Eigen::Vector3d& normal) {
  // The world axis least along the normal, so that the cross product is far from zero.
  Eigen::Vector3d seed = Eigen::Vector3d::UnitX();
  if (std::abs(normal.x()) >= 0.8) seed = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = (seed - normal * normal.dot(seed)).normalized();
  return {x, normal.cross(x)};
}

Eigen::Quaterniond CanonicalQuaternion(const Eigen::Matrix3d& rotation) {
  constexpr double kGrid = 1.0 / (1LL << 44);
  // At least one component of a unit quaternion has a size of 0.5; the first one found stays free, so that it
  // makes the length 1 while the others lie on the grid.
  constexpr double kLargeEnough = 0.5 - 1e-9;
  Eigen::Vector4d wxyz;
  {
    const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
    wxyz << q.w(), q.x(), q.y(), q.z();
  }
  int free = 0;
  while (free < 3 && !(std::abs(wxyz[free]) >= kLargeEnough)) ++free;
  if (wxyz[free] < 0.0) wxyz = -wxyz;
  double rest = 1.0;
  for (int i = 0; i < 4; ++i) {
    if (i == free) continue;
    wxyz[i] = std::round(wxyz[i] / kGrid) * kGrid;
    rest -= wxyz[i] * wxyz[i];
  }
  wxyz[free] = std::sqrt(rest);
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

Eigen::Isometry3d CanonicalPose(const Eigen::Isometry3d& pose) {
  Eigen::Isometry3d canonical = Eigen::Isometry3d::Identity();
  canonical.linear() = CanonicalQuaternion(pose.linear()).toRotationMatrix();
  canonical.translation() = pose.translation();
  return canonical;
}

double SignedArea(const Ring& ring, const Eigen::Vector3d& normal) {
  Eigen::Vector3d twice_area = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    // Relative to the first vertex: far from the origin the plain sum loses digits.
    twice_area += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
  }
  return 0.5 * twice_area.dot(normal);
}

}  // namespace terrace
