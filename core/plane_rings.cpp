// SPDX-License-Identifier: BSD-3-Clause
#include "core/plane_rings.h"

#include <algorithm>
#include <utility>

namespace terrace {
namespace {

/// Edges that come closer than this touch: outlines are written with six decimals.
constexpr double kTouching_m = 5e-5;

/// On which side of the line through a and b a point lies; 0 on it.
int SideOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const Eigen::Vector2d d = b - a;
  const double across = Cross(d, p - a), limit = kTouching_m * d.norm();
  return across > limit ? 1 : across < -limit ? -1 : 0;
}

bool OnSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return p.x() <= std::max(a.x(), b.x()) + kTouching_m && p.x() >= std::min(a.x(), b.x()) - kTouching_m &&
         p.y() <= std::max(a.y(), b.y()) + kTouching_m && p.y() >= std::min(a.y(), b.y()) - kTouching_m;
}

bool SegmentsTouch(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                   const Eigen::Vector2d& d) {
  const auto apart = [](double from, double to, double other_from, double other_to) {
    return std::max(from, to) + kTouching_m < std::min(other_from, other_to) ||
           std::max(other_from, other_to) + kTouching_m < std::min(from, to);
  };
  if (apart(a.x(), b.x(), c.x(), d.x()) || apart(a.y(), b.y(), c.y(), d.y())) return false;
  const int s1 = SideOf(a, b, c), s2 = SideOf(a, b, d);
  const int s3 = SideOf(c, d, a), s4 = SideOf(c, d, b);
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

bool Contains(const Ring2& ring, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++)
    if (CrossesRay(ring[i], ring[j], p)) inside = !inside;
  return inside;
}

void MarkFarVertices(const Ring2& ring, std::size_t first, std::size_t last, double tolerance_m,
                     std::vector<bool>* marked) {
  std::vector<std::pair<std::size_t, std::size_t>> chains{{first, last}};
  const std::size_t n = ring.size();
  while (!chains.empty()) {
    const auto [begin, end] = chains.back();
    chains.pop_back();
    double farthest = tolerance_m;
    std::size_t split = begin;
    const Eigen::Vector2d &from = ring[begin % n], &to = ring[end % n];
    for (std::size_t i = begin + 1; i < end; ++i) {
      const Eigen::Vector2d& p = ring[i % n];
      // Relative to the chain's beginning: rings traced on a grid have ties, which rounding decides.
      const double d = (p - from - ShareAlong(from, to, p) * (to - from)).norm();
      if (d > farthest) {
        farthest = d;
        split = i;
      }
    }
    if (split == begin) continue;
    (*marked)[split % n] = true;
    chains.emplace_back(begin, split);
    chains.emplace_back(split, end);
  }
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
