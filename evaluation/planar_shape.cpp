// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/planar_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {

PlanarShape::PlanarShape(const Plane& plane, const Ring& outline, const std::vector<Ring>& holes)
    : plane_(plane), axes_(AxesOf(plane.normal)) {
  const auto add = [this](const Ring& ring) {
    Ring2& flat = rings_.emplace_back();
    for (const Eigen::Vector3d& p : ring) flat.push_back(InPlane(p));
  };
  add(outline);
  for (const Eigen::Vector2d& q : rings_.front()) box_.extend(q);
  for (const Ring& hole : holes) add(hole);
}

bool PlanarShape::LiesOver(const Eigen::Vector3d& p) const { return Contains(InPlane(p)); }

double PlanarShape::AngleTo(const Plane& other) const {
  const double cosine = std::abs(plane_.normal.dot(other.normal));
  return std::acos(std::min(cosine, 1.0));
}

bool PlanarShape::Contains(const Eigen::Vector2d& q) const {
  if (!box_.contains(q)) return false;
  // Even-odd rule over all rings at once: a point in a hole crosses two outlines.
  bool inside = false;
  for (const Ring2& ring : rings_) inside = inside != terrace::Contains(ring, q);
  return inside;
}

double PlanarShape::DistanceToEdge(const Eigen::Vector3d& p) const {
  const Eigen::Vector2d q = InPlane(p);
  double least_square = std::numeric_limits<double>::infinity();
  for (const Ring2& ring : rings_)
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++)
      least_square = std::min(least_square, (NearestOnSegment(ring[j], ring[i], q) - q).squaredNorm());
  return std::sqrt(least_square);
}

void PlanarShape::ForEachCell(double cell_m, const std::function<void(const Eigen::Vector3d&)>& use) const {
  const Eigen::Vector2d extent = box_.sizes();
  const auto columns = static_cast<std::int64_t>(std::llround(extent.x() / cell_m));
  const auto rows = static_cast<std::int64_t>(std::llround(extent.y() / cell_m));
  const Eigen::Vector2d corner =
      box_.center() - 0.5 * cell_m * Eigen::Vector2d(static_cast<double>(columns), static_cast<double>(rows));
  const Eigen::Vector3d on_plane = plane_.normal * plane_.offset_m;
  for (std::int64_t i = 0; i < columns; ++i) {
    for (std::int64_t j = 0; j < rows; ++j) {
      const Eigen::Vector2d q =
          corner + cell_m * Eigen::Vector2d(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
      if (Contains(q)) use(axes_.x * q.x() + axes_.y * q.y() + on_plane);
    }
  }
}

Ring Moved(const Eigen::Isometry3d& T_to_from, const Ring& ring) {
  Ring moved;
  moved.reserve(ring.size());
  for (const Eigen::Vector3d& p : ring) moved.push_back(T_to_from * p);
  return moved;
}

Plane Moved(const Eigen::Isometry3d& T_to_from, const Plane& plane) {
  const Eigen::Vector3d normal = T_to_from.linear() * plane.normal;
  return {normal, plane.offset_m + normal.dot(T_to_from.translation())};
}

}  // namespace terrace
