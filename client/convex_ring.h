// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "client/flat_polygon.h"

namespace terrace {

// Convex counter-clockwise rings.

FlatRing RingOf(const Eigen::AlignedBox2d& box);
/// What of the ring has normal . p <= offset; empty: nothing.
FlatRing Cut(const FlatRing& ring, const Eigen::Vector2d& normal, double offset);
/// Middle of the area, and the area's mean square distances from it.
struct AreaMoments {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};
AreaMoments MomentsOf(const FlatRing& ring);
/// The ring without the vertices that add least, until it has at most that many; lies within the ring.
FlatRing WithFewerVertices(FlatRing ring, std::size_t max_vertices, const Eigen::Vector2d& keep_inside);
/// The part of a segment that lies inside the ring; none: it does not reach in, or only touches.
std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> PartInside(const FlatRing& ring,
                                                                      const Eigen::Vector2d& a,
                                                                      const Eigen::Vector2d& b);
bool Inside(const FlatRing& ring, const Eigen::Vector2d& point);

}  // namespace terrace
