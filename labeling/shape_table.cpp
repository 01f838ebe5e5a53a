// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/shape_table.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace terrace {
namespace {

/// Within this distance of the camera everything is looked at in every frame: farther than stairs are made
/// out, and than a robot steps before it looks again.
constexpr double kNear = 8.0;
/// So far does a change decide about its neighbours.
constexpr double kBeside = 0.5;
/// Shapes are kept within this distance: what lies nearer comes and goes in view.
constexpr double kFar = 20.0;
/// After a turn of the level frame so many regions far away are looked at in a frame, found among so many.
constexpr int kAnew = 16;
constexpr int kAskedWhetherAnew = 512;
/// So many shapes a frame are asked whether they are far.
constexpr int kAskedWhetherFar = 8;

}  // namespace

bool ShapeTable::HoldGravity(const Gravity& gravity) {
  const Eigen::Vector3d up = gravity.up_world().normalized();
  const double turned = std::acos(std::clamp(up.dot(R_level_world_.transpose().col(2)), -1.0, 1.0));
  if (!regions_.empty() && turned <= max_gravity_change_rad_) return false;
  R_level_world_ = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return true;
}

void ShapeTable::Update(const PolygonUpdate& update, const Gravity& gravity,
                        const Eigen::Vector3d& eye_world) {
  if (HoldGravity(gravity)) BeginLevelFrame();
  ReplaceChanged(update);
  TouchSomeOfAnOldFrame();
  ChooseActive(eye_world);
  DropFarShapes(eye_world);
}

void ShapeTable::BeginLevelFrame() {
  ++level_frame_;
  looked_at_to_ = 0;
}

void ShapeTable::ReplaceChanged(const PolygonUpdate& update) {
  touched_.clear();
  removed_.clear();
  for (const PolygonId id : update.removed) {
    const auto gone = regions_.find(id);
    if (gone == regions_.end()) continue;
    removed_.push_back(id);
    touched_.push_back(gone->second.box_world);
    grid_.Remove(id, gone->second.box_world);
    with_shape_.erase(id);
    regions_.erase(gone);
  }
  std::sort(removed_.begin(), removed_.end());
  for (const PolygonPtr& polygon : update.changed) Put(polygon);
}

void ShapeTable::Put(const PolygonPtr& polygon) {
  Region& region = regions_[polygon->id];
  if (region.polygon) {
    if (region.polygon == polygon) return;
    touched_.push_back(region.box_world);
    grid_.Remove(polygon->id, region.box_world);
    with_shape_.erase(polygon->id);
  }
  region = {polygon, {}, nullptr, level_frame_};
  for (const Eigen::Vector3d& p : polygon->outline_world) region.box_world.extend(p);
  touched_.push_back(region.box_world);
  grid_.Add(polygon->id, region.box_world);
}

void ShapeTable::TouchSomeOfAnOldFrame() {
  if (looked_at_to_ < 0) return;
  auto at = regions_.upper_bound(looked_at_to_);
  int num_touched = 0;
  for (int i = 0; i < kAskedWhetherAnew && num_touched < kAnew && at != regions_.end(); ++i, ++at) {
    looked_at_to_ = at->first;
    if (at->second.level_frame == level_frame_) continue;
    touched_.push_back(at->second.box_world);
    ++num_touched;
  }
  if (at == regions_.end()) looked_at_to_ = -1;
}

void ShapeTable::ChooseActive(const Eigen::Vector3d& eye_world) {
  const Eigen::AlignedBox3d near(eye_world - Eigen::Vector3d::Constant(kNear),
                                 eye_world + Eigen::Vector3d::Constant(kNear));
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
    Region& region = regions_.at(id);
    if (std::none_of(places.begin(), places.end(),
                     [&](const Eigen::AlignedBox3d& place) { return place.intersects(region.box_world); }))
      continue;
    const bool turned = std::exchange(region.level_frame, level_frame_) != level_frame_;
    if (turned) touched_.push_back(region.box_world);
    if (turned || !region.shape) {
      region.shape = ShapeOf(region.polygon);
      with_shape_.insert(id);
    }
    active_.push_back(region.shape);
  }
}

/// A few in turns, so that it costs the same however many there are.
void ShapeTable::DropFarShapes(const Eigen::Vector3d& eye_world) {
  auto at = with_shape_.upper_bound(checked_to_);
  for (int i = 0; i < kAskedWhetherFar && at != with_shape_.end(); ++i) {
    checked_to_ = *at;
    Region& region = regions_.at(*at);
    const bool far = region.box_world.squaredExteriorDistance(eye_world) > kFar * kFar;
    if (far) region.shape = nullptr;
    at = far ? with_shape_.erase(at) : std::next(at);
  }
  if (at == with_shape_.end()) checked_to_ = 0;
}

int ShapeTable::IndexOf(PolygonId id) const {
  const auto it =
      std::lower_bound(active_.begin(), active_.end(), id,
                       [](const RegionShapePtr& s, PolygonId wanted) { return s->id() < wanted; });
  return it != active_.end() && (*it)->id() == id ? static_cast<int>(it - active_.begin()) : -1;
}

PolygonPtr ShapeTable::Find(PolygonId id) const {
  const auto found = regions_.find(id);
  return found == regions_.end() ? nullptr : found->second.polygon;
}

bool ShapeTable::Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const {
  const Eigen::AlignedBox3d& box = regions_.at(shape.id()).box_world;
  const Eigen::AlignedBox3d wide(box.min() - reach, box.max() + reach);
  return std::any_of(touched_.begin(), touched_.end(),
                     [&](const Eigen::AlignedBox3d& touched) { return wide.intersects(touched); });
}

}  // namespace terrace
