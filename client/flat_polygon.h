// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "client/box_tree.h"
#include "core/plane_rings.h"

namespace terrace {

/// A closed ring in the axes of a plane [m]; the first vertex is not repeated.
using FlatRing = Ring2;

/// A polygon with holes (or several polygons that do not overlap) in the axes of a plane, ready to be asked.
/// Edges are counted through: edge i starts at vertex i of the rings laid end to end.
class FlatPolygon {
 public:
  FlatPolygon() = default;
  explicit FlatPolygon(std::vector<FlatRing> rings);

  const std::vector<FlatRing>& rings() const { return rings_; }
  bool empty() const { return edges_.empty(); }
  std::size_t num_edges() const { return edges_.size(); }
  const Eigen::Vector2d& start(std::size_t edge) const { return edges_[edge].first; }
  const Eigen::Vector2d& end(std::size_t edge) const { return edges_[edge].second; }
  double area_m2() const { return area_m2_; }  ///< outlines less holes
  Eigen::AlignedBox2d box() const;

  /// Whether the point is inside, by the number of edges towards +x. On an edge: either.
  bool Contains(const Eigen::Vector2d& point) const;

  struct Approach {
    std::size_t edge = 0;
    Eigen::Vector2d point = Eigen::Vector2d::Zero();              ///< of the edge, the nearest
    double distance_m = std::numeric_limits<double>::infinity();  ///< infinite: there is no edge
  };
  /// The point of the edges that is nearest.
  Approach NearestEdge(const Eigen::Vector2d& point) const;
  /// The same among the edges for which counts(edge) holds.
  template <typename Counts>
  Approach NearestEdge(const Eigen::Vector2d& point, const Counts& counts) const;

  /// The tree over the edges, for other questions.
  const BoxTree<2>& tree() const { return tree_; }

 private:
  std::vector<FlatRing> rings_;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> edges_;
  BoxTree<2> tree_;
  double area_m2_ = 0.0;
};

template <typename Counts>
FlatPolygon::Approach FlatPolygon::NearestEdge(const Eigen::Vector2d& point, const Counts& counts) const {
  const auto nearest =
      tree_.FindNearest([&](const Eigen::AlignedBox2d& box) { return box.squaredExteriorDistance(point); },
                        [&](std::size_t i) {
                          if (!counts(i)) return std::numeric_limits<double>::infinity();
                          return (NearestOnSegment(start(i), end(i), point) - point).squaredNorm();
                        });
  if (nearest.squared_distance == std::numeric_limits<double>::infinity()) return {};
  return {nearest.index, NearestOnSegment(start(nearest.index), end(nearest.index), point),
          std::sqrt(nearest.squared_distance)};
}

}  // namespace terrace
