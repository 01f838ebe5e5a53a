// SPDX-License-Identifier: BSD-3-Clause
#include "client/convex_ring.h"

#include <algorithm>
#include <limits>

#include "core/plane_rings.h"

namespace terrace {

FlatRing RingOf(const Eigen::AlignedBox2d& box) {
  return {box.min(), {box.max().x(), box.min().y()}, box.max(), {box.min().x(), box.max().y()}};
}

FlatRing Cut(const FlatRing& ring, const Eigen::Vector2d& normal, double offset) {
  FlatRing kept;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d& a = ring[i];
    const Eigen::Vector2d& b = ring[(i + 1) % ring.size()];
    const double over_a = normal.dot(a) - offset;
    const double over_b = normal.dot(b) - offset;
    if (over_a <= 0.0) kept.push_back(a);
    if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0))
      kept.push_back(a + over_a / (over_a - over_b) * (b - a));
  }
  return kept.size() >= 3 ? kept : FlatRing{};
}

AreaMoments MomentsOf(const FlatRing& ring) {
  // By the triangles from the first vertex: mean p p^T over one with corners a, b, c is
  // (a a^T + b b^T + c c^T + s s^T) / 12 with s = a + b + c.
  double area = 0.0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    const Eigen::Vector2d b = ring[i] - ring[0];
    const Eigen::Vector2d c = ring[i + 1] - ring[0];
    const double triangle = 0.5 * Cross(b, c);
    area += triangle;
    first += triangle * (b + c) / 3.0;
    second += triangle * (b * b.transpose() + c * c.transpose() + (b + c) * (b + c).transpose()) / 12.0;
  }
  const Eigen::Vector2d mean = first / area;
  return {ring[0] + mean, second / area - mean * mean.transpose()};
}

std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> PartInside(const FlatRing& ring,
                                                                      const Eigen::Vector2d& a,
                                                                      const Eigen::Vector2d& b) {
  // After Cyrus and Beck (1978). What reaches in by less than this is a matter of rounding.
  constexpr double kTouch_m = 1e-7;
  double enter = 0.0;
  double leave = 1.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d side = ring[(i + 1) % ring.size()] - ring[i];
    if (side.norm() < 1e-12) continue;  // two vertices that a cut has brought together
    const Eigen::Vector2d inward = Eigen::Vector2d(-side.y(), side.x()).normalized();
    const double depth_a = inward.dot(a - ring[i]) - kTouch_m;
    const double depth_b = inward.dot(b - ring[i]) - kTouch_m;
    if (depth_a <= 0.0 && depth_b <= 0.0) return std::nullopt;
    if (depth_a < 0.0) enter = std::max(enter, depth_a / (depth_a - depth_b));
    if (depth_b < 0.0) leave = std::min(leave, depth_a / (depth_a - depth_b));
  }
  if (enter >= leave) return std::nullopt;
  return std::pair<Eigen::Vector2d, Eigen::Vector2d>{a + enter * (b - a), a + leave * (b - a)};
}

bool Inside(const FlatRing& ring, const Eigen::Vector2d& point) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    if (Cross(ring[(i + 1) % ring.size()] - ring[i], point - ring[i]) < 0.0) return false;
  }
  return ring.size() >= 3;
}

FlatRing WithFewerVertices(FlatRing ring, std::size_t max_vertices, const Eigen::Vector2d& keep_inside) {
  while (ring.size() > max_vertices && ring.size() > 3) {
    std::size_t least = ring.size();
    double least_area = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d& before = ring[(i + ring.size() - 1) % ring.size()];
      const Eigen::Vector2d& after = ring[(i + 1) % ring.size()];
      const double area = 0.5 * Cross(ring[i] - before, after - before);
      if (area < least_area && Cross(after - before, keep_inside - before) >= 0.0) {
        least = i;
        least_area = area;
      }
    }
    if (least == ring.size()) break;
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(least));
  }
  return ring;
}

}  // namespace terrace
