// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/gravity_from_planes.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"

namespace terrace {
namespace {

// Floors of buildings are level within about 0.3 deg; streets are not, and get no better than their own
// scatter.
constexpr double kFloorSigma = Radians(0.3);
// Smaller planes are boxes and steps that may stand askew.
constexpr double kMinArea = 0.3;

}  // namespace

std::optional<GravityHint> GravityFromPlanes(const PolygonUpdate& polygons, const PoseEstimate&,
                                             const Gravity& gravity) {
  const bool assumed = gravity.source == GravitySource::kAssumed;
  const Eigen::Vector3d up = gravity.up_world();
  const double widest =
      assumed ? Radians(45.0) : std::clamp(3.0 * gravity.sigma_rad, Radians(3.0), Radians(10.0));

  const Polygon* dominant = nullptr;
  for (const PolygonPtr& polygon : polygons.polygons) {
    if (polygon->area_m2 < kMinArea) continue;
    if (polygon->plane_world.normal.dot(up) < std::cos(widest)) continue;
    if (dominant == nullptr || polygon->area_m2 > dominant->area_m2) dominant = polygon.get();
  }
  if (dominant == nullptr) return std::nullopt;

  // The dominant plane and those parallel to it: a ramp beside a floor must not pull.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double information = 0.0;
  for (const PolygonPtr& polygon : polygons.polygons) {
    if (polygon->area_m2 < kMinArea) continue;
    if (polygon->plane_world.normal.dot(dominant->plane_world.normal) < std::cos(Radians(3.0))) continue;
    const double tilt_variance =
        polygon->plane_covariance.topLeftCorner<2, 2>().trace() + kFloorSigma * kFloorSigma;
    sum += polygon->plane_world.normal / tilt_variance;
    information += 1.0 / tilt_variance;
  }
  GravityHint hint;
  hint.frame_id = polygons.frame_id;
  hint.down_world = -sum.normalized();
  hint.sigma_rad = std::max(kFloorSigma, std::sqrt(1.0 / information));
  return hint;
}

}  // namespace terrace
