// SPDX-License-Identifier: BSD-3-Clause
#include "client/flat_polygon.h"

#include <algorithm>

namespace terrace {

double FlatArea(const FlatRing& ring) {
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    // Relative to the first vertex: far from the origin the plain sum loses digits.
    const Eigen::Vector2d a = ring[i] - ring[0];
    const Eigen::Vector2d b = ring[(i + 1) % ring.size()] - ring[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

FlatPolygon::FlatPolygon(std::vector<FlatRing> rings) : rings_(std::move(rings)) {
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const FlatRing& ring : rings_) {
    area_m2_ += FlatArea(ring);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      edges_.emplace_back(ring[i], ring[(i + 1) % ring.size()]);
      boxes.emplace_back(edges_.back().first);
      boxes.back().extend(edges_.back().second);
    }
  }
  tree_ = BoxTree<2>(std::move(boxes));
}

Eigen::AlignedBox2d FlatPolygon::box() const {
  Eigen::AlignedBox2d box;
  for (const auto& [a, b] : edges_) box.extend(a);
  return box;
}

bool FlatPolygon::Contains(const Eigen::Vector2d& point) const {
  bool inside = false;
  tree_.ForEach(
      [&](const Eigen::AlignedBox2d& box) {
        return box.min().y() <= point.y() && point.y() <= box.max().y() && point.x() <= box.max().x();
      },
      [&](std::size_t i) {
        const auto& [a, b] = edges_[i];
        if ((a.y() > point.y()) == (b.y() > point.y())) return;
        const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        if (point.x() < x) inside = !inside;
      });
  return inside;
}

FlatPolygon::Approach FlatPolygon::NearestEdge(const Eigen::Vector2d& point) const {
  return NearestEdge(point, [](std::size_t) { return true; });
}

Eigen::Vector2d NearestOnSegment(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                 const Eigen::Vector2d& point) {
  const Eigen::Vector2d along = b - a;
  const double squared_length = along.squaredNorm();
  if (squared_length == 0.0) return a;
  return a + std::clamp(along.dot(point - a) / squared_length, 0.0, 1.0) * along;
}

}  // namespace terrace
