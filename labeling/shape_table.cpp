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
  ReplaceChanged(update);
  if (all_anew) MakeAllAnew();
  ChooseActive(R_level_world_ * eye_world);
}

void ShapeTable::ReplaceChanged(const PolygonUpdate& update) {
  touched_.clear();
  removed_.clear();
  for (const PolygonId id : update.removed) {
    const auto gone = all_.find(id);
    if (gone == all_.end()) continue;
    removed_.push_back(id);
    touched_.push_back(gone->second->bounds);
    grid_.Remove(*gone->second);
    all_.erase(gone);
  }
  std::sort(removed_.begin(), removed_.end());
  for (const PolygonPtr& polygon : update.changed) Put(polygon);
}

void ShapeTable::Put(const PolygonPtr& polygon) {
  RegionShapePtr& shape = all_[polygon->id];
  if (shape) {
    if (shape->polygon == polygon) return;
    touched_.push_back(shape->bounds);
    grid_.Remove(*shape);
  }
  shape = MakeRegionShape(polygon, R_level_world_, limits_);
  touched_.push_back(shape->bounds);
  grid_.Add(*shape);
}

void ShapeTable::MakeAllAnew() {
  grid_.Clear();
  for (auto& [id, shape] : all_) {
    touched_.push_back(shape->bounds);
    shape = MakeRegionShape(shape->polygon, R_level_world_, limits_);
    touched_.push_back(shape->bounds);
    grid_.Add(*shape);
  }
}

void ShapeTable::ChooseActive(const Eigen::Vector3d& eye_level) {
  const Eigen::AlignedBox3d near(eye_level - Eigen::Vector3d::Constant(kNear),
                                 eye_level + Eigen::Vector3d::Constant(kNear));
  const Eigen::Vector3d beside = Eigen::Vector3d::Constant(kBeside);
  std::vector<Eigen::AlignedBox3d> places{near};
  for (const Eigen::AlignedBox3d& box : touched_)
    if (!near.contains(box)) places.emplace_back(box.min() - beside, box.max() + beside);
  std::vector<PolygonId> ids;
  for (const Eigen::AlignedBox3d& place : places) grid_.Collect(place, &ids);
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  active_.clear();
  for (const PolygonId id : ids) {
    const RegionShapePtr& shape = all_.at(id);
    if (std::any_of(places.begin(), places.end(),
                    [&](const Eigen::AlignedBox3d& place) { return place.intersects(shape->bounds); }))
      active_.push_back(shape);
  }
}

int ShapeTable::IndexOf(PolygonId id) const {
  const auto it =
      std::lower_bound(active_.begin(), active_.end(), id,
                       [](const RegionShapePtr& s, PolygonId wanted) { return s->id() < wanted; });
  return it != active_.end() && (*it)->id() == id ? static_cast<int>(it - active_.begin()) : -1;
}

const RegionShape* ShapeTable::Find(PolygonId id) const {
  const auto found = all_.find(id);
  return found == all_.end() ? nullptr : found->second.get();
}

bool ShapeTable::Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const {
  const Eigen::AlignedBox3d wide(shape.bounds.min() - reach, shape.bounds.max() + reach);
  return std::any_of(touched_.begin(), touched_.end(),
                     [&](const Eigen::AlignedBox3d& box) { return wide.intersects(box); });
}

}  // namespace terrace
