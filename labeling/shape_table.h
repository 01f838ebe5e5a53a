// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include <Eigen/Geometry>

#include "core/pose_estimate.h"
#include "labeling/box_grid.h"
#include "labeling/region_shape.h"

namespace terrace {

/// The regions of the map, and the shapes in the level frame of those that are looked at: those near the
/// robot, those that the last frame changed, and those that lie beside such a change. What is decided of the
/// others stays. When gravity turns, so does the level frame: those near the robot are looked at anew at
/// once, the others some in every frame.
///
/// What always holds: a shape that is looked at is one in the level frame as it is now. Of regions far from
/// the robot no shapes are kept.
class ShapeTable {
 public:
  /// @param max_gravity_change_rad  the level frame turns when gravity has turned by more than this
  ShapeTable(const RegionShapeLimits& limits, double max_gravity_change_rad)
      : limits_(limits), max_gravity_change_rad_(max_gravity_change_rad) {}

  /// @param eye_world  where the camera is
  void Update(const PolygonUpdate& update, const Gravity& gravity, const Eigen::Vector3d& eye_world);

  std::size_t size() const { return regions_.size(); }
  const std::vector<RegionShapePtr>& shapes() const { return active_; }  ///< to be looked at, ascending by id
  /// Ids of those that went with the last frame, ascending.
  const std::vector<PolygonId>& removed() const { return removed_; }
  const Eigen::Matrix3d& R_level_world() const { return R_level_world_; }
  int IndexOf(PolygonId id) const;      ///< among those to be looked at; -1: it is not
  PolygonPtr Find(PolygonId id) const;  ///< among all; null: there is none
  /// Of any polygon, in the level frame as it is now.
  RegionShapePtr ShapeOf(const PolygonPtr& polygon) const {
    return MakeRegionShape(polygon, R_level_world_, limits_);
  }
  /// True when the last frame changed something within reach of a shape that is looked at, along the axes of
  /// the world.
  bool Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const;

 private:
  struct Region {
    PolygonPtr polygon;
    Eigen::AlignedBox3d box_world;
    RegionShapePtr shape;  ///< null: made when it is looked at
    int level_frame = 0;   ///< in which it was looked at last
  };
  using Regions = std::map<PolygonId, Region>;

  bool HoldGravity(const Gravity& gravity);
  void BeginLevelFrame();
  void ReplaceChanged(const PolygonUpdate& update);
  void Put(const PolygonPtr& polygon);
  void TouchSomeOfAnOldFrame();
  void ChooseActive(const Eigen::Vector3d& eye_world);
  void DropFarShapes(const Eigen::Vector3d& eye_world);

  RegionShapeLimits limits_;
  double max_gravity_change_rad_;
  Eigen::Matrix3d R_level_world_ = Eigen::Matrix3d::Identity();
  int level_frame_ = 0;          ///< counts its turns
  PolygonId looked_at_to_ = -1;  ///< all up to this one were looked at since it turned; -1: all were
  Regions regions_;
  BoxGrid grid_;  ///< of all
  std::set<PolygonId> with_shape_;
  PolygonId checked_to_ = 0;  ///< of those with a shape, for one that is far
  std::vector<RegionShapePtr> active_;
  std::vector<PolygonId> removed_;
  std::vector<Eigen::AlignedBox3d> touched_;  ///< where the last frame changed something; world
};

}  // namespace terrace
