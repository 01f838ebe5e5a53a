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

void LevelPlanes::Update(const PolygonUpdate& update) {
  frame_id_ = update.frame_id;
  const auto place = [&](PolygonId id) {
    return std::lower_bound(planes_.begin(), planes_.end(), id,
                            [](const LargePlane& plane, PolygonId wanted) { return plane.id < wanted; });
  };
  const auto forget = [&](PolygonId id) {
    const auto at = place(id);
    if (at != planes_.end() && at->id == id) planes_.erase(at);
  };
  for (const PolygonId id : update.removed) forget(id);
  for (const PolygonPtr& polygon : update.changed) {
    if (polygon->area_m2 < kMinArea) {
      forget(polygon->id);
      continue;
    }
    auto at = place(polygon->id);
    if (at == planes_.end() || at->id != polygon->id) at = planes_.insert(at, LargePlane());
    const double tilt_variance =
        polygon->plane_covariance.topLeftCorner<2, 2>().trace() + kFloorSigma * kFloorSigma;
    *at = {polygon->id, polygon->plane_world.normal, polygon->area_m2, tilt_variance};
  }
}

std::optional<GravityHint> LevelPlanes::Hint(const Gravity& gravity) const {
  const bool assumed = gravity.source == GravitySource::kAssumed;
  const Eigen::Vector3d up = gravity.up_world();
  const double widest =
      assumed ? Radians(45.0) : std::clamp(3.0 * gravity.sigma_rad, Radians(3.0), Radians(10.0));
  const double least_cosine = std::cos(widest);

  const LargePlane* dominant = nullptr;
  for (const LargePlane& plane : planes_) {
    if (plane.normal_world.dot(up) < least_cosine) continue;
    if (dominant == nullptr || plane.area_m2 > dominant->area_m2) dominant = &plane;
  }
  if (dominant == nullptr) return std::nullopt;

  // The dominant plane and those parallel to it: a ramp beside a floor must not pull.
  const double parallel = std::cos(Radians(3.0));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double information = 0.0;
  for (const LargePlane& plane : planes_) {
    if (plane.normal_world.dot(dominant->normal_world) < parallel) continue;
    sum += plane.normal_world / plane.tilt_variance;
    information += 1.0 / plane.tilt_variance;
  }
  GravityHint hint;
  hint.frame_id = frame_id_;
  hint.down_world = -sum.normalized();
  hint.sigma_rad = std::max(kFloorSigma, std::sqrt(1.0 / information));
  return hint;
}

}  // namespace terrace
