// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
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

/// Whether the ray from p towards +x crosses the edge from a to b. A ring's edges, each end counted to one
/// side only: so a ray through a vertex crosses once or not at all.
inline bool CrossesRay(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  return (a.y() > p.y()) != (b.y() > p.y()) &&
         p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

/// Whether a point lies inside a ring; on the ring itself either answer may come.
bool Contains(const Ring2& ring, const Eigen::Vector2d& p);

/// Where on the segment from a to b the point nearest to p lies, from 0 to 1.
template <typename Vector>
double ShareAlong(const Vector& a, const Vector& b, const Vector& p) {
  const Vector along = b - a;
  const double length2 = along.squaredNorm();
  return length2 > 0.0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0.0;
}

/// The point of the segment from a to b that is nearest to p.
inline Eigen::Vector2d NearestOnSegment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                        const Eigen::Vector2d& p) {
  return a + ShareAlong(a, b, p) * (b - a);
}
inline Eigen::Vector3d NearestOnSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        const Eigen::Vector3d& p) {
  return a + ShareAlong(a, b, p) * (b - a);
}

/// Douglas and Peucker: marks the vertices of the open chain first..last of a ring (indices may run past its
/// end) that must stay so that none that goes is farther than the tolerance from what remains; the two ends
/// are not marked.
void MarkFarVertices(const Ring2& ring, std::size_t first, std::size_t last, double tolerance_m,
                     std::vector<bool>* marked);

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
