// SPDX-License-Identifier: BSD-3-Clause
#include "client/region_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {

RegionShape::RegionShape(const TerrainRegion& region)
    : normal_(region.plane_world.normal),
      centroid_(region.plane_world.Project(region.centroid_world)),
      axes_(AxesOf(normal_)),
      covariance_(region.plane_covariance),
      edges_(region.edges) {
  std::vector<FlatRing> rings;
  const auto add = [&](const Ring& ring_world) {
    FlatRing& ring = rings.emplace_back();
    for (const Eigen::Vector3d& p : ring_world) {
      ring.push_back(ToPlane(p));
      box_world_.extend(p);
    }
  };
  add(region.outline_world);
  for (const Ring& hole : region.holes_world) add(hole);
  polygon_ = FlatPolygon(std::move(rings));
  edges_.resize(polygon_.num_edges());  // none given: limits of view
}

double RegionShape::SigmaHeight(const Eigen::Vector2d& flat) const {
  // No plane is known exactly: zeros are what a map has that came from a file without covariances.
  if (covariance_.isZero(0.0)) return std::numeric_limits<double>::quiet_NaN();
  // A tilt about x lifts what lies at +y, one about y lowers what lies at +x.
  const Eigen::Vector3d lift(flat.y(), -flat.x(), 1.0);
  return std::sqrt(std::max(0.0, lift.dot(covariance_ * lift))) / std::abs(normal_.z());
}

std::shared_ptr<const FlatPolygon> RegionShape::Inset(const EdgeMargins& margins) const {
  const std::lock_guard lock(mutex_);
  auto& inset = insets_[margins];
  if (!inset) inset = std::make_shared<const FlatPolygon>(InsetOf(polygon_, edges_, margins));
  return inset;
}

}  // namespace terrace
