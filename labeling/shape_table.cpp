// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/shape_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terrace {

void ShapeTable::HoldGravity(const Gravity& gravity) {
  const Eigen::Vector3d up = gravity.up_world().normalized();
  const double turned = std::acos(std::clamp(up.dot(R_level_world_.transpose().col(2)), -1.0, 1.0));
  if (shapes_.empty() || turned > max_gravity_change_rad_) {
    R_level_world_ = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    by_id_.clear();
  }
}

void ShapeTable::Update(const PolygonUpdate& update, const Gravity& gravity) {
  HoldGravity(gravity);
  std::map<PolygonId, RegionShapePtr> by_id;
  shapes_.clear();
  touched_.clear();
  for (const PolygonPtr& polygon : update.polygons) {
    const auto known = by_id_.find(polygon->id);
    const bool same = known != by_id_.end() && known->second->polygon == polygon;
    RegionShapePtr shape = same ? known->second : MakeRegionShape(polygon, R_level_world_, limits_);
    if (!same) {
      touched_.push_back(shape->bounds);
      if (known != by_id_.end()) touched_.push_back(known->second->bounds);
    }
    if (known != by_id_.end()) by_id_.erase(known);
    by_id.emplace(polygon->id, shape);
    shapes_.push_back(std::move(shape));
  }
  for (const auto& [id, gone] : by_id_) touched_.push_back(gone->bounds);
  by_id_ = std::move(by_id);
}

int ShapeTable::IndexOf(PolygonId id) const {
  const auto it =
      std::lower_bound(shapes_.begin(), shapes_.end(), id,
                       [](const RegionShapePtr& s, PolygonId wanted) { return s->id() < wanted; });
  return it != shapes_.end() && (*it)->id() == id ? static_cast<int>(it - shapes_.begin()) : -1;
}

bool ShapeTable::Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const {
  const Eigen::AlignedBox3d wide(shape.bounds.min() - reach, shape.bounds.max() + reach);
  return std::any_of(touched_.begin(), touched_.end(),
                     [&](const Eigen::AlignedBox3d& box) { return wide.intersects(box); });
}

}  // namespace terrace
