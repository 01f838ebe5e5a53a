// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/ring_simplifier.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace terrace {
namespace {

// Beyond this a simplified outline would no longer be the shape.
constexpr double kMaxTolerance = 0.2;

int NumVertices(const std::vector<Ring2>& rings) {
  std::size_t num = 0;
  for (const Ring2& ring : rings) num += ring.size();
  return static_cast<int>(num);
}

struct Line2 {
  Eigen::Vector2d point;
  Eigen::Vector2d direction;
};

/// Line of least squares through the middles of the little edges from vertex `first` to `last`, by their
/// length.
Line2 FitLine(const Ring2& ring, int first, int last) {
  const int n = static_cast<int>(ring.size());
  const Eigen::Vector2d start = ring[first % n], end = ring[last % n];
  double weight = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d outer = Eigen::Matrix2d::Zero();
  for (int i = first; i < last; ++i) {
    const Eigen::Vector2d a = ring[i % n] - start, b = ring[(i + 1) % n] - start;
    const double w = (b - a).norm();
    const Eigen::Vector2d middle = 0.5 * (a + b);
    weight += w;
    sum += w * middle;
    outer += w * (middle * middle.transpose() + (b - a) * (b - a).transpose() / 12.0);
  }
  const Eigen::Vector2d mean = sum / weight;
  const Eigen::Matrix2d c = outer / weight - mean * mean.transpose();
  const double angle = 0.5 * std::atan2(2.0 * c(0, 1), c(0, 0) - c(1, 1));
  Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
  if (direction.dot(end - start) < 0.0) direction = -direction;
  return {start + mean, direction};
}

/// A traced ring with fewer vertices, no edge farther than a tolerance from what it replaces; edges are lines
/// fitted to what they replace. Where that makes edges touch, Refine() brings traced vertices back.
class SimplifiedRing {
 public:
  SimplifiedRing(const Ring2& traced, double tolerance, double line_reach_m,
                 const std::vector<EdgeLine>& lines)
      : traced_(&traced),
        tolerance_(tolerance),
        line_reach_m_(line_reach_m),
        edge_lines_(lines),
        keep_(traced.size(), false),
        pinned_(traced.size(), false) {
    const int n = static_cast<int>(traced.size());
    // The chain is cut at two vertices far apart, which no simplification would drop.
    int a = 0;
    for (int i = 1; i < n; ++i)
      if (traced[i].x() + traced[i].y() < traced[a].x() + traced[a].y()) a = i;
    int b = a;
    for (int i = 0; i < n; ++i)
      if ((traced[i] - traced[a]).squaredNorm() > (traced[b] - traced[a]).squaredNorm()) b = i;
    keep_[a] = keep_[b] = true;
    const int second = b > a ? b : b + n;
    MarkFarVertices(traced, a, second, tolerance, &keep_);
    MarkFarVertices(traced, second, a + n, tolerance, &keep_);
    Build();
    if (ring_.size() < 3 || SignedArea(ring_) * SignedArea(traced) <= 0.0) KeepAll();
  }

  const Ring2& ring() const { return ring_; }

  /// The edge that starts at vertex `index` gives way: its ends go back to where they were traced, and what
  /// it replaces is halved. Takes effect with the next Build().
  void Refine(std::size_t index) {
    const int n = static_cast<int>(traced_->size());
    const int first = kept_[index];
    const int last = index + 1 < kept_.size() ? kept_[index + 1] : kept_[0] + n;
    for (const int i : {first, (first + last) / 2, last}) keep_[i % n] = pinned_[i % n] = true;
  }

  void KeepAll() {
    std::fill(keep_.begin(), keep_.end(), true);
    pinned_ = keep_;
    Build();
  }

  void Build() {
    const Ring2& traced = *traced_;
    const int n = static_cast<int>(traced.size());
    kept_.clear();
    ring_.clear();
    for (int i = 0; i < n; ++i)
      if (keep_[i]) kept_.push_back(i);
    const int m = static_cast<int>(kept_.size());
    if (m < 3) return;
    // A traced edge runs along pixels; the line fitted to it is finer than they are.
    std::vector<Line2> lines;
    std::vector<bool> given;
    for (int i = 0; i < m; ++i) {
      const int first = kept_[i], last = i + 1 < m ? kept_[i + 1] : kept_[0] + n;
      const EdgeLine* line = LineAlong(traced[first], traced[last % n]);
      given.push_back(line != nullptr);
      lines.push_back(line ? Line2{line->point, line->along} : FitLine(traced, first, last));
    }
    for (int i = 0; i < m; ++i) {
      const int previous = (i + m - 1) % m;
      ring_.push_back(pinned_[kept_[i]]
                          ? traced[kept_[i]]
                          : Corner(traced[kept_[i]], lines[previous], given[previous], lines[i], given[i]));
    }
  }

 private:
  /// The line that an edge lies on; null when there is none.
  const EdgeLine* LineAlong(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    const double length = (b - a).norm();
    if (length < 2.0 * line_reach_m_) return nullptr;
    const EdgeLine* best = nullptr;
    double least = line_reach_m_;
    for (const EdgeLine& line : edge_lines_) {
      // The surface lies to the left of its rings. Both sides of a thin strip on one line would make them
      // touch.
      if (Cross(b - a, line.inside) <= 0.0) continue;
      const double middle = line.along.dot(0.5 * (a + b) - line.point);
      if (middle < line.from_m - line_reach_m_ || middle > line.to_m + line_reach_m_) continue;
      const double away =
          std::max(std::abs(Cross(line.along, a - line.point)), std::abs(Cross(line.along, b - line.point)));
      if (away > least) continue;
      least = away;
      best = &line;
    }
    return best;
  }

  /// Where two edges meet, if that is near the traced vertex between them; else on the line that is given.
  Eigen::Vector2d Corner(const Eigen::Vector2d& traced, const Line2& before, bool before_given,
                         const Line2& after, bool after_given) const {
    const double sine = Cross(before.direction, after.direction);
    if (std::abs(sine) > 0.2) {
      const double t = Cross(after.point - before.point, after.direction) / sine;
      const Eigen::Vector2d meeting = before.point + t * before.direction;
      if ((meeting - traced).norm() < 2.0 * tolerance_) return meeting;
    }
    if (!before_given && !after_given) return traced;
    const Line2& line = before_given ? before : after;
    return line.point + line.direction.dot(traced - line.point) * line.direction;
  }

  const Ring2* traced_;
  double tolerance_;
  double line_reach_m_;
  const std::vector<EdgeLine>& edge_lines_;
  std::vector<bool> keep_;    // traced vertices that stay
  std::vector<bool> pinned_;  // and may not move
  std::vector<int> kept_;
  Ring2 ring_;
};

std::vector<Ring2> SimplifiedBy(const std::vector<Ring2>& traced, double tolerance, double line_reach_m,
                                const std::vector<EdgeLine>& lines) {
  std::vector<SimplifiedRing> simplified;
  for (const Ring2& ring : traced) simplified.emplace_back(ring, tolerance, line_reach_m, lines);
  // Each pass halves what the touching edges replace, so that a dozen reach single pixels; the rest are for
  // edges that only come to touch by it.
  constexpr int kMaxPasses = 40;
  bool touching = true;
  for (int pass = 0; pass < kMaxPasses && touching; ++pass) {
    std::vector<const Ring2*> rings;
    for (const SimplifiedRing& ring : simplified) rings.push_back(&ring.ring());
    const std::vector<RingEdge> edges = TouchingEdges(rings);
    for (const RingEdge& edge : edges) simplified[edge.ring].Refine(edge.index);
    for (SimplifiedRing& ring : simplified) ring.Build();
    touching = !edges.empty();
  }
  std::vector<Ring2> rings;
  for (SimplifiedRing& ring : simplified) {
    if (touching) ring.KeepAll();
    rings.push_back(ring.ring());
  }
  return rings;
}

}  // namespace

std::vector<Ring2> SimplifyRings(const std::vector<Ring2>& traced, const SimplifySettings& settings,
                                 const std::vector<EdgeLine>& lines) {
  double tolerance = settings.tolerance_m;
  std::vector<Ring2> rings = SimplifiedBy(traced, tolerance, settings.line_reach_m, lines);
  while (NumVertices(rings) > settings.max_vertices && tolerance < kMaxTolerance) {
    tolerance *= 1.5;
    std::vector<Ring2> coarser = SimplifiedBy(traced, tolerance, settings.line_reach_m, lines);
    // Rings that would touch get vertices back, so that coarser is not always fewer.
    if (NumVertices(coarser) < NumVertices(rings)) rings = std::move(coarser);
  }
  // An outline that is drawn back to a line may leave a hole beside it, which is none any more.
  const auto outline =
      std::find_if(rings.begin(), rings.end(), [](const Ring2& ring) { return SignedArea(ring) > 0.0; });
  if (outline != rings.end()) {
    const Ring2 around = *outline;
    std::erase_if(rings,
                  [&](const Ring2& ring) { return SignedArea(ring) < 0.0 && !Contains(around, ring[0]); });
  }
  return rings;
}

}  // namespace terrace
