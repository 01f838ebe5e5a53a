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

double SignedArea(const Ring& ring, const Eigen::Vector3d& normal) {
  Eigen::Vector3d twice_area = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    // Relative to the first vertex: far from the origin the plain sum loses digits.
    twice_area += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
  }
  return 0.5 * twice_area.dot(normal);
}

}  // namespace terrace
