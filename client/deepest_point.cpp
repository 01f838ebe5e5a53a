// SPDX-License-Identifier: BSD-3-Clause
#include "client/deepest_point.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

namespace terrace {
namespace {

struct Square {
  Eigen::Vector2d middle;
  double half_m;
  double depth_m;    // of the middle; negative: outside
  double promise_m;  // the deepest that a point of it can be
};

bool operator<(const Square& a, const Square& b) {
  return std::tuple(a.promise_m, a.middle.x(), a.middle.y()) <
         std::tuple(b.promise_m, b.middle.x(), b.middle.y());
}

Square SquareAt(const FlatPolygon& polygon, const Eigen::Vector2d& middle, double half_m) {
  const double distance_m = polygon.NearestEdge(middle).distance_m;
  const double depth_m = polygon.Contains(middle) ? distance_m : -distance_m;
  return {middle, half_m, depth_m, depth_m + half_m * std::sqrt(2.0)};
}

}  // namespace

DeepPoint DeepestPoint(const FlatPolygon& polygon, double precision_m) {
  DeepPoint deepest;
  if (polygon.empty()) return deepest;
  std::priority_queue<Square> open;
  const Eigen::AlignedBox2d box = polygon.box();
  const double half_m = std::max(0.5 * box.sizes().minCoeff(), precision_m);
  for (double x = box.min().x(); x < box.max().x(); x += 2.0 * half_m) {
    for (double y = box.min().y(); y < box.max().y(); y += 2.0 * half_m)
      open.push(SquareAt(polygon, {x + half_m, y + half_m}, half_m));
  }
  while (!open.empty() && open.top().promise_m > deepest.depth_m + precision_m) {
    const Square square = open.top();
    open.pop();
    if (square.depth_m > deepest.depth_m) deepest = {square.middle, square.depth_m};
    for (const double sx : {-0.5, 0.5}) {
      for (const double sy : {-0.5, 0.5})
        open.push(
            SquareAt(polygon, square.middle + square.half_m * Eigen::Vector2d(sx, sy), 0.5 * square.half_m));
    }
  }
  return deepest;
}

}  // namespace terrace
