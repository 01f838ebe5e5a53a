// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_rings.h"

#include <algorithm>

namespace terrace {
namespace {

int Sign(double value) { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

bool OnSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return p.x() <= std::max(a.x(), b.x()) && p.x() >= std::min(a.x(), b.x()) &&
         p.y() <= std::max(a.y(), b.y()) && p.y() >= std::min(a.y(), b.y());
}

bool SegmentsTouch(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                   const Eigen::Vector2d& d) {
  if (std::max(a.x(), b.x()) < std::min(c.x(), d.x()) || std::max(c.x(), d.x()) < std::min(a.x(), b.x()) ||
      std::max(a.y(), b.y()) < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) < std::min(a.y(), b.y()))
    return false;
  const int s1 = Sign(Cross(b - a, c - a)), s2 = Sign(Cross(b - a, d - a));
  const int s3 = Sign(Cross(d - c, a - c)), s4 = Sign(Cross(d - c, b - c));
  if (s1 != s2 && s3 != s4) return true;
  return (s1 == 0 && OnSegment(c, a, b)) || (s2 == 0 && OnSegment(d, a, b)) ||
         (s3 == 0 && OnSegment(a, c, d)) || (s4 == 0 && OnSegment(b, c, d));
}

}  // namespace

double SignedArea(const Ring2& ring) {
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i)
    twice += Cross(ring[i] - ring[0], ring[(i + 1) % ring.size()] - ring[0]);
  return 0.5 * twice;
}

std::vector<RingEdge> TouchingEdges(const std::vector<const Ring2*>& rings) {
  struct Edge {
    Eigen::Vector2d a, b;
    RingEdge name;
    std::size_t count;
    double low_x;
  };
  std::vector<Edge> edges;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const Ring2& ring = *rings[r];
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
      edges.push_back({a, b, {r, i}, ring.size(), std::min(a.x(), b.x())});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& l, const Edge& r) { return l.low_x < r.low_x; });
  const auto follows = [](const Edge& e, const Edge& f) {
    return e.name.ring == f.name.ring && (e.name.index + 1) % e.count == f.name.index;
  };
  const auto turns_back = [](const Edge& e, const Edge& f) {
    return Cross(e.b - e.a, f.b - f.a) == 0.0 && (e.b - e.a).dot(f.b - f.a) < 0.0;
  };
  std::vector<RingEdge> touching;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge& e = edges[i];
    if (e.a == e.b) touching.push_back(e.name);
    const double high_x = std::max(e.a.x(), e.b.x());
    for (std::size_t j = i + 1; j < edges.size() && edges[j].low_x <= high_x; ++j) {
      const Edge& f = edges[j];
      const bool touch = follows(e, f)   ? turns_back(e, f)
                         : follows(f, e) ? turns_back(f, e)
                                         : SegmentsTouch(e.a, e.b, f.a, f.b);
      if (!touch) continue;
      touching.push_back(e.name);
      touching.push_back(f.name);
    }
  }
  return touching;
}

bool AreSimple(const std::vector<const Ring2*>& rings) {
  return std::all_of(rings.begin(), rings.end(), [](const Ring2* ring) { return ring->size() >= 3; }) &&
         TouchingEdges(rings).empty();
}

}  // namespace terrace
