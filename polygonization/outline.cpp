// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

constexpr double kMaxPixels = 4e6;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

int RadiusPx(double width_m, double pixel_m) { return static_cast<int>(std::floor(0.5 * width_m / pixel_m)); }

cv::Mat Disk(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius + 1, 2 * radius + 1));
}

/// True when no pixel among eight touches one of the next row at a corner only.
bool NoDiagonals(const std::uint8_t* row, const std::uint8_t* next) {
  const auto load = [](const std::uint8_t* from) {
    std::uint64_t eight;
    std::memcpy(&eight, from, sizeof eight);
    return eight;
  };
  const std::uint64_t here = load(row), below = load(next);
  return ((here ^ load(row + 1)) & (below ^ load(next + 1)) & (here ^ below)) == 0;
}

/// Two pixels of one piece that touch at a corner only would make a ring touch itself: fills one of the
/// others. Pixels are 0 or 255.
void FillDiagonals(cv::Mat1b* image) {
  for (bool again = true; again;) {
    again = false;
    for (int y = 0; y + 1 < image->rows; ++y) {
      std::uint8_t* row = image->ptr(y);
      std::uint8_t* next = image->ptr(y + 1);
      for (int x = 0; x + 1 < image->cols; ++x) {
        if (x + 8 < image->cols && NoDiagonals(row + x, next + x)) {
          x += 7;
          continue;
        }
        if (row[x] != next[x + 1] || row[x + 1] != next[x] || row[x] == row[x + 1]) continue;
        (row[x] ? row[x + 1] : row[x]) = 255;
        again = true;
      }
    }
  }
}

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * d).norm();
}

/// Douglas and Peucker on the open chain first..last (indices that may run past the end of the ring).
void KeepFarVertices(const Ring2& ring, int first, int last, double tolerance, std::vector<bool>* keep) {
  const int n = static_cast<int>(ring.size());
  int farthest = -1;
  double distance = tolerance;
  for (int i = first + 1; i < last; ++i) {
    const double d = DistanceToSegment(ring[i % n], ring[first % n], ring[last % n]);
    if (d > distance) {
      distance = d;
      farthest = i;
    }
  }
  if (farthest < 0) return;
  (*keep)[farthest % n] = true;
  KeepFarVertices(ring, first, farthest, tolerance, keep);
  KeepFarVertices(ring, farthest, last, tolerance, keep);
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

namespace {

/// The edge of rings[ring] that starts at its vertex `index`.
struct RingEdge {
  std::size_t ring = 0;
  std::size_t index = 0;
};

/// Edges that touch another one, but neighbours at their common vertex, or that have no length.
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

/// A traced ring with fewer vertices, no edge farther than a tolerance from what it replaces; edges are lines
/// fitted to what they replace. Where that makes edges touch, Refine() brings traced vertices back.
class SimplifiedRing {
 public:
  SimplifiedRing(const Ring2& traced, double tolerance)
      : traced_(&traced), tolerance_(tolerance), keep_(traced.size(), false), pinned_(traced.size(), false) {
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
    KeepFarVertices(traced, a, second, tolerance, &keep_);
    KeepFarVertices(traced, second, a + n, tolerance, &keep_);
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
    for (int i = 0; i < m; ++i)
      lines.push_back(FitLine(traced, kept_[i], i + 1 < m ? kept_[i + 1] : kept_[0] + n));
    for (int i = 0; i < m; ++i) {
      const Line2& before = lines[(i + m - 1) % m];
      const Line2& after = lines[i];
      Eigen::Vector2d vertex = traced[kept_[i]];
      const double sine = Cross(before.direction, after.direction);
      if (!pinned_[kept_[i]] && std::abs(sine) > 0.2) {
        const double t = Cross(after.point - before.point, after.direction) / sine;
        const Eigen::Vector2d meeting = before.point + t * before.direction;
        if ((meeting - vertex).norm() < 2.0 * tolerance_) vertex = meeting;
      }
      ring_.push_back(vertex);
    }
  }

 private:
  const Ring2* traced_;
  double tolerance_;
  std::vector<bool> keep_;    // traced vertices that stay
  std::vector<bool> pinned_;  // and may not move
  std::vector<int> kept_;
  Ring2 ring_;
};

// Beyond this a simplified outline would no longer be the shape.
constexpr double kMaxTolerance = 0.2;

int NumVertices(const std::vector<Ring2>& rings) {
  std::size_t num = 0;
  for (const Ring2& ring : rings) num += ring.size();
  return static_cast<int>(num);
}

/// Simplifies the rings of one shape so that they neither cross nor touch; the traced rings themselves never
/// do.
std::vector<Ring2> SimplifyShape(const std::vector<Ring2>& traced, double tolerance) {
  std::vector<SimplifiedRing> simplified;
  for (const Ring2& ring : traced) simplified.emplace_back(ring, tolerance);
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

bool AreSimple(const std::vector<const Ring2*>& rings) {
  return std::all_of(rings.begin(), rings.end(), [](const Ring2* ring) { return ring->size() >= 3; }) &&
         TouchingEdges(rings).empty();
}

OutlineTracer::OutlineTracer(const OutlineSettings& settings, const Eigen::Vector2d& low,
                             const Eigen::Vector2d& high)
    : settings_(settings), pixel_m_(settings.resolution_m) {
  const Eigen::Vector2d size = high - low;
  while ((size.x() / pixel_m_ + 1.0) * (size.y() / pixel_m_ + 1.0) > kMaxPixels) pixel_m_ *= 2.0;
  // A margin, so that closing never meets the border. Pixels lie on a grid fixed in the plane: an outline
  // does not shiver when the plane's extent grows.
  const int margin = RadiusPx(settings.max_gap_m, pixel_m_) + 2;
  low_ = pixel_m_ * ((low / pixel_m_).array().floor() - margin).matrix();
  const Eigen::Vector2d num = ((high - low_) / pixel_m_).array().ceil() + margin;
  filled_ = cv::Mat1b::zeros(static_cast<int>(num.y()), static_cast<int>(num.x()));
}

void OutlineTracer::Fill(const Eigen::Vector2d& centre, const Eigen::Vector2d& half_x,
                         const Eigen::Vector2d& half_y) {
  const Eigen::Vector2d c = (centre - low_) / pixel_m_ - Eigen::Vector2d::Constant(0.5);  // in pixel centres
  const Eigen::Vector2d hx = half_x / pixel_m_, hy = half_y / pixel_m_;
  const double ex = std::abs(hx.x()) + std::abs(hy.x()), ey = std::abs(hx.y()) + std::abs(hy.y());
  const int y0 = std::max(0, static_cast<int>(std::ceil(c.y() - ey)));
  const int y1 = std::min(filled_.rows - 1, static_cast<int>(std::floor(c.y() + ey)));
  for (int y = y0; y <= y1; ++y) {
    // The rectangle is where |d . h| <= |h|^2 for both half axes h: of each row an interval.
    double low = c.x() - ex, high = c.x() + ex;
    for (const Eigen::Vector2d& h : {hx, hy}) {
      const double limit = std::max(h.squaredNorm(), 1e-12), across = h.y() * (y - c.y());
      if (std::abs(h.x()) < 1e-9) {
        if (std::abs(across) > limit) high = low - 1.0;
        continue;
      }
      const double middle = c.x() - across / h.x(), reach = limit / std::abs(h.x());
      low = std::max(low, middle - reach);
      high = std::min(high, middle + reach);
    }
    const int x0 = std::max(0, static_cast<int>(std::ceil(low)));
    const int x1 = std::min(filled_.cols - 1, static_cast<int>(std::floor(high)));
    if (x0 <= x1) std::fill_n(filled_.ptr(y) + x0, x1 - x0 + 1, std::uint8_t{255});
  }
}

std::vector<PlanarShape> OutlineTracer::Trace() {
  cv::Mat1b closed = filled_.clone();
  const int close_px = RadiusPx(settings_.max_gap_m, pixel_m_);
  const int open_px = RadiusPx(settings_.min_width_m, pixel_m_);
  if (close_px > 0) cv::morphologyEx(closed, closed, cv::MORPH_CLOSE, Disk(close_px));
  if (open_px > 0) {
    // Opening rounds corners; growing back inside the old shape restores them and leaves the tongues away.
    cv::Mat1b opened;
    cv::morphologyEx(closed, opened, cv::MORPH_OPEN, Disk(open_px));
    cv::dilate(opened, opened, Disk(open_px));
    closed &= opened;
  }
  FillDiagonals(&closed);
  pieces_ = BitmapPieces(closed);
  shape_of_piece_.assign(pieces_.pieces().size(), -1);
  const std::vector<int> num_filled = pieces_.CountSet(filled_);
  std::vector<PlanarShape> shapes;
  const double pixel_area = pixel_m_ * pixel_m_;
  for (std::size_t i = 0; i < pieces_.pieces().size(); ++i) {
    const BitmapPieces::Piece& piece = pieces_.pieces()[i];
    if (piece.num_pixels * pixel_area < settings_.min_area_m2) continue;
    std::vector<Ring2> traced;
    for (const std::vector<cv::Point>& corners : pieces_.TraceRings(static_cast<int>(i))) {
      Ring2 ring;
      for (const cv::Point& corner : corners)
        ring.push_back(low_ + pixel_m_ * Eigen::Vector2d(corner.x, corner.y));
      // Small holes are gaps in the data.
      if (SignedArea(ring) < 0.0 && -SignedArea(ring) < settings_.min_area_m2) continue;
      traced.push_back(std::move(ring));
    }
    double tolerance = settings_.simplify_m * pixel_m_ / settings_.resolution_m;
    std::vector<Ring2> rings = SimplifyShape(traced, tolerance);
    while (NumVertices(rings) > settings_.max_vertices && tolerance < kMaxTolerance) {
      tolerance *= 1.5;
      std::vector<Ring2> coarser = SimplifyShape(traced, tolerance);
      // Rings that would touch get vertices back, so that coarser is not always fewer.
      if (NumVertices(coarser) < NumVertices(rings)) rings = std::move(coarser);
    }
    PlanarShape shape;
    for (Ring2& ring : rings) {
      shape.area_m2 += SignedArea(ring);
      if (SignedArea(ring) > 0.0)
        shape.outline = std::move(ring);
      else
        shape.holes.push_back(std::move(ring));
    }
    shape.centroid = low_ + pixel_m_ * (piece.centroid + Eigen::Vector2d::Constant(0.5));
    shape.support = std::min(1.0, double(num_filled[i]) / piece.num_pixels);
    shape_of_piece_[i] = static_cast<int>(shapes.size());
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

int OutlineTracer::ShapeAt(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d at = (p - low_) / pixel_m_;
  const int piece =
      pieces_.PieceAt(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
  return piece < 0 ? -1 : shape_of_piece_[piece];
}

}  // namespace terrace
