// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/drop_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/angles.h"

namespace terrace {
namespace {

/// Outlines are off by a few centimetres: so far beyond the edge the ground would have gone on.
constexpr double kBeyond = 0.10;
/// Ground under ground, as mirrors make it, comes in scraps that are seen for a moment.
constexpr double kMinArea = 0.04;
constexpr int kMinLooks = 3;

/// True when a point of the shape's plane belongs to the shape.
bool On(const RegionShape& shape, const Eigen::Vector3d& p) {
  constexpr double kOff = 0.05;
  const Eigen::Vector3d outside = (shape.bounds.min() - p).cwiseMax(p - shape.bounds.max());
  if (outside.maxCoeff() > kOff) return false;
  // The bounds of an upright face are its outline well enough.
  return shape.lean == Lean::kUpright || shape.PlanDistance(p.head<2>()) <= kOff;
}

}  // namespace

double HeightSigma(const RegionShape& support, const Eigen::Vector2d& p) {
  const Eigen::Matrix3d& c = support.polygon->plane_covariance;
  const double away = (p - support.centroid.head<2>()).norm();
  return std::sqrt(c(2, 2) + std::max(c(0, 0), c(1, 1)) * away * away);
}

std::optional<RegionEdge> DropSeenOver(const Eigen::Vector3d& edge, const Eigen::Vector2d& outward,
                                       const Eigen::Vector3d& eye, const RegionShape& self,
                                       const std::vector<const RegionShape*>& lower) {
  const Eigen::Vector3d beyond(edge.x() + kBeyond * outward.x(), edge.y() + kBeyond * outward.y(), edge.z());
  const Eigen::Vector3d ray = beyond - eye;
  if (ray.z() >= 0.0 || ray.norm() > kFarthestDrop) return std::nullopt;
  const RegionShape* first = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (const RegionShape* shape : lower) {
    if (shape->area_m2 < kMinArea || shape->polygon->num_observations < kMinLooks) continue;
    const double slant = shape->plane.normal.dot(ray);
    if (slant >= 0.0) continue;  // seen from behind
    const double t = -shape->plane.SignedDistance(eye) / slant;
    if (t <= 1.0 || t >= nearest) continue;
    const Eigen::Vector3d hit = eye + t * ray;
    if (hit.z() > edge.z() - kMinDrop || !On(*shape, hit)) continue;
    nearest = t;
    first = shape;
  }
  if (!first) return std::nullopt;
  RegionEdge drop{EdgeKind::kDrop, {}, {}};
  constexpr double kLevel = Radians(12.0);
  if (first->lean == Lean::kSupport && first->slope_rad < kLevel) {
    drop.step_m = first->HeightAt(edge.head<2>()) - edge.z();
    drop.sigma_m = std::hypot(HeightSigma(self, edge.head<2>()), HeightSigma(*first, edge.head<2>()));
  }
  return drop;
}

}  // namespace terrace
