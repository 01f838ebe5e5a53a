// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/plan_geometry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace terrace {
PlanRing SimplifyPlan(const PlanRing& ring, double tolerance_m) {
  const std::size_t n = ring.size();
  if (n <= 4) return ring;
  // The vertex farthest from the first one starts a second chain.
  std::size_t opposite = 0;
  double farthest2 = 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    const double d2 = (ring[i] - ring[0]).squaredNorm();
    if (d2 > farthest2) {
      farthest2 = d2;
      opposite = i;
    }
  }
  if (opposite == 0) return ring;
  std::vector<bool> kept(n, false);
  kept[0] = kept[opposite] = true;
  MarkFarVertices(ring, 0, opposite, tolerance_m, &kept);
  MarkFarVertices(ring, opposite, n, tolerance_m, &kept);
  PlanRing simple;
  for (std::size_t i = 0; i < n; ++i)
    if (kept[i]) simple.push_back(ring[i]);
  return simple.size() >= 3 ? simple : ring;
}

Eigen::Vector2d NearestOnRing(const PlanRing& ring, const Eigen::Vector2d& p) {
  // The labels spend most of their time here: plain numbers, no division for edges that are too far away.
  Eigen::Vector2d nearest = ring.front();
  double nearest2 = std::numeric_limits<double>::infinity();
  double ax = ring.back().x() - p.x();
  double ay = ring.back().y() - p.y();
  for (const Eigen::Vector2d& end : ring) {
    const double bx = end.x() - p.x();
    const double by = end.y() - p.y();
    const double dx = bx - ax;
    const double dy = by - ay;
    const double length2 = dx * dx + dy * dy;
    const double cross = ax * by - ay * bx;
    // The line through the edge is no nearer than the edge itself.
    if (cross * cross < nearest2 * length2) {
      const double t = std::clamp(-(ax * dx + ay * dy) / length2, 0.0, 1.0);
      const double qx = ax + t * dx;
      const double qy = ay + t * dy;
      const double d2 = qx * qx + qy * qy;
      if (d2 < nearest2) {
        nearest2 = d2;
        nearest = {p.x() + qx, p.y() + qy};
      }
    }
    ax = bx;
    ay = by;
  }
  return nearest;
}

Interval Extent(const PlanRing& ring, const Eigen::Vector2d& axis) {
  Interval extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Eigen::Vector2d& p : ring) {
    extent.low = std::min(extent.low, axis.dot(p));
    extent.high = std::max(extent.high, axis.dot(p));
  }
  return extent;
}

Interval MiddleExtent(const PlanRing& ring, const Eigen::Vector2d& axis, const Interval& across) {
  constexpr int kNumLines = 15;
  const Eigen::Vector2d left(-axis.y(), axis.x());
  std::vector<double> lows, highs;
  for (int line = 0; line < kNumLines; ++line) {
    const double at = across.low + across.length() * (line + 0.5) / kNumLines;
    Interval hit{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const double a = left.dot(ring[j]) - at, b = left.dot(ring[i]) - at;
      if ((a < 0.0) == (b < 0.0)) continue;
      const double along = axis.dot(ring[j] + (ring[i] - ring[j]) * (a / (a - b)));
      hit.low = std::min(hit.low, along);
      hit.high = std::max(hit.high, along);
    }
    if (hit.low > hit.high) continue;
    lows.push_back(hit.low);
    highs.push_back(hit.high);
  }
  if (lows.empty()) return Extent(ring, axis);
  const auto middle = [](std::vector<double>& ends) {
    const auto nth = ends.begin() + static_cast<std::ptrdiff_t>(ends.size() / 2);
    std::nth_element(ends.begin(), nth, ends.end());
    return *nth;
  };
  return {middle(lows), middle(highs)};
}

PlanRectangle SmallestRectangle(const PlanRing& ring) {
  PlanRectangle smallest;
  double smallest_area = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Eigen::Vector2d edge = ring[i] - ring[j];
    const double length = edge.norm();
    if (length < 1e-9) continue;
    const Eigen::Vector2d axis = edge / length;
    const Eigen::Vector2d across(-axis.y(), axis.x());
    const Interval along = Extent(ring, axis);
    const Interval beside = Extent(ring, across);
    const double area = along.length() * beside.length();
    if (area >= smallest_area) continue;
    smallest_area = area;
    smallest.center = axis * along.middle() + across * beside.middle();
    const bool along_is_longer = along.length() >= beside.length();
    smallest.long_axis = along_is_longer ? axis : across;
    smallest.length_m = std::max(along.length(), beside.length());
    smallest.depth_m = std::min(along.length(), beside.length());
  }
  return smallest;
}

double LargestSquare(const std::vector<PlanRing>& rings, const PlanRectangle& rectangle, double enough_m) {
  constexpr int kCellsPerEdge = 10;
  constexpr double kMaxCells = 40000.0;  // bounds time and memory; a larger region gets larger cells
  double cell = enough_m / kCellsPerEdge;
  const double area = rectangle.length_m * rectangle.depth_m;
  if (area / (cell * cell) > kMaxCells) cell = std::sqrt(area / kMaxCells);
  // Rows run along the long axis.
  const int columns = static_cast<int>(rectangle.length_m / cell);
  const int rows = static_cast<int>(rectangle.depth_m / cell);
  const int enough = static_cast<int>(std::ceil(enough_m / cell - 1e-9));
  if (columns <= 0 || rows <= 0) return 0.0;

  const Eigen::Vector2d origin = rectangle.center - rectangle.long_axis * (0.5 * columns * cell) -
                                 rectangle.short_axis() * (0.5 * rows * cell);
  // squares[c] is the edge, in cells, of the largest square whose last corner is cell c of the current row.
  std::vector<int> squares(columns, 0);
  std::vector<double> crossings;
  int largest = 0;
  for (int row = 0; row < rows; ++row) {
    crossings.clear();
    const double y = (row + 0.5) * cell;
    for (const PlanRing& ring : rings) {
      for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        const double ya = rectangle.short_axis().dot(ring[j] - origin);
        const double yb = rectangle.short_axis().dot(ring[i] - origin);
        if ((ya > y) == (yb > y)) continue;
        const double xa = rectangle.long_axis.dot(ring[j] - origin);
        const double xb = rectangle.long_axis.dot(ring[i] - origin);
        crossings.push_back(xa + (xb - xa) * (y - ya) / (yb - ya));
      }
    }
    std::sort(crossings.begin(), crossings.end());
    std::size_t next = 0;
    int diagonal = 0;  // squares[column - 1] of the row before
    for (int column = 0; column < columns; ++column) {
      const double x = (column + 0.5) * cell;
      while (next < crossings.size() && crossings[next] <= x) ++next;
      const bool inside = next % 2 == 1;  // even-odd: a hole turns the inside off again
      const int above = squares[column];
      const int left = column > 0 ? squares[column - 1] : 0;
      squares[column] = inside ? 1 + std::min({above, left, diagonal}) : 0;
      diagonal = above;
      largest = std::max(largest, squares[column]);
    }
    if (largest >= enough) return enough_m;
  }
  return largest * cell;
}

}  // namespace terrace
