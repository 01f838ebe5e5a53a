// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/shape_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terrace {
namespace {

/// Within this distance of the camera everything is looked at in every frame: farther than stairs are made
/// out, and than a robot steps before it looks again.
constexpr double kNear = 8.0;
/// So far does a change decide about its neighbours.
constexpr double kBeside = 0.5;

const RegionShapePtr* FindIn(const std::vector<RegionShapePtr>& shapes, PolygonId id) {
  const auto it =
      std::lower_bound(shapes.begin(), shapes.end(), id,
                       [](const RegionShapePtr& s, PolygonId wanted) { return s->id() < wanted; });
  return it != shapes.end() && (*it)->id() == id ? &*it : nullptr;
}

}  // namespace

bool ShapeTable::HoldGravity(const Gravity& gravity) {
  const Eigen::Vector3d up = gravity.up_world().normalized();
  const double turned = std::acos(std::clamp(up.dot(R_level_world_.transpose().col(2)), -1.0, 1.0));
  if (!all_.empty() && turned <= max_gravity_change_rad_) return false;
  R_level_world_ = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return true;
}

void ShapeTable::Update(const PolygonUpdate& update, const Gravity& gravity,
                        const Eigen::Vector3d& eye_world) {
  const bool all_anew = HoldGravity(gravity);
  ReplaceChanged(update, all_anew);
  ChooseActive(R_level_world_ * eye_world);
}

void ShapeTable::ReplaceChanged(const PolygonUpdate& update, bool all_anew) {
  // Both lists ascend by id: one walk finds what is new, changed and gone.
  std::vector<RegionShapePtr> all;
  all.reserve(update.polygons.size());
  touched_.clear();
  auto before = all_.begin();
  for (const PolygonPtr& polygon : update.polygons) {
    for (; before != all_.end() && (*before)->id() < polygon->id; ++before)
      touched_.push_back((*before)->bounds);
    const bool known = before != all_.end() && (*before)->id() == polygon->id;
    if (known && !all_anew && (*before)->polygon == polygon) {
      all.push_back(std::move(*before++));
      continue;
    }
    if (known) touched_.push_back((*before++)->bounds);
    all.push_back(MakeRegionShape(polygon, R_level_world_, limits_));
    touched_.push_back(all.back()->bounds);
  }
  for (; before != all_.end(); ++before) touched_.push_back((*before)->bounds);
  all_ = std::move(all);
}

void ShapeTable::ChooseActive(const Eigen::Vector3d& eye_level) {
  const Eigen::AlignedBox3d near(eye_level - Eigen::Vector3d::Constant(kNear),
                                 eye_level + Eigen::Vector3d::Constant(kNear));
  const Eigen::Vector3d beside = Eigen::Vector3d::Constant(kBeside);
  std::vector<Eigen::AlignedBox3d> far_changes;
  for (const Eigen::AlignedBox3d& box : touched_)
    if (!near.contains(box)) far_changes.emplace_back(box.min() - beside, box.max() + beside);
  active_.clear();
  for (const RegionShapePtr& shape : all_) {
    const bool active = near.intersects(shape->bounds) || std::any_of(far_changes.begin(), far_changes.end(),
                                                                      [&](const Eigen::AlignedBox3d& box) {
                                                                        return box.intersects(shape->bounds);
                                                                      });
    if (active) active_.push_back(shape);
  }
}

int ShapeTable::IndexOf(PolygonId id) const {
  const RegionShapePtr* found = FindIn(active_, id);
  return found ? static_cast<int>(found - active_.data()) : -1;
}

const RegionShape* ShapeTable::Find(PolygonId id) const {
  const RegionShapePtr* found = FindIn(all_, id);
  return found ? found->get() : nullptr;
}

bool ShapeTable::Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const {
  const Eigen::AlignedBox3d wide(shape.bounds.min() - reach, shape.bounds.max() + reach);
  return std::any_of(touched_.begin(), touched_.end(),
                     [&](const Eigen::AlignedBox3d& box) { return wide.intersects(box); });
}

}  // namespace terrace
