// SPDX-License-Identifier: BSD-3-Clause
#include "client/flat_polygon.h"

#include <algorithm>

namespace terrace {

FlatPolygon::FlatPolygon(std::vector<FlatRing> rings) : rings_(std::move(rings)) {
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const FlatRing& ring : rings_) {
    area_m2_ += SignedArea(ring);
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
        if (CrossesRay(a, b, point)) inside = !inside;
      });
  return inside;
}

FlatPolygon::Approach FlatPolygon::NearestEdge(const Eigen::Vector2d& point) const {
  return NearestEdge(point, [](std::size_t) { return true; });
}

}  // namespace terrace
