// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace terrace {

/// A closed ring in coordinates of its plane; the first vertex is not repeated.
using Ring2 = std::vector<Eigen::Vector2d>;

/// z of the cross product.
inline double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Area with sign: positive when counter-clockwise.
double SignedArea(const Ring2& ring);

/// Whether a point lies inside a ring; on the ring itself either answer may come.
bool Contains(const Ring2& ring, const Eigen::Vector2d& p);

/// The edge of rings[ring] that starts at its vertex `index`.
struct RingEdge {
  std::size_t ring = 0;
  std::size_t index = 0;
};

/// Edges that touch another one, but neighbours at their common vertex, or that have no length.
std::vector<RingEdge> TouchingEdges(const std::vector<const Ring2*>& rings);

/// True when no two edges of the rings touch, but neighbours at their common vertex.
bool AreSimple(const std::vector<const Ring2*>& rings);

}  // namespace terrace
