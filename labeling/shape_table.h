// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "core/pose_estimate.h"
#include "labeling/region_shape.h"
#include "labeling/shape_grid.h"

namespace terrace {

/// The shapes of all regions of the map in the level frame. Only those near the robot, and those that the
/// last frame changed or that lie beside such a change, are looked at: what is decided of the others stays.
class ShapeTable {
 public:
  /// @param max_gravity_change_rad  the level frame turns when gravity has turned by more than this
  ShapeTable(const RegionShapeLimits& limits, double max_gravity_change_rad)
      : limits_(limits), max_gravity_change_rad_(max_gravity_change_rad) {}

  /// @param eye_world  where the camera is
  void Update(const PolygonUpdate& update, const Gravity& gravity, const Eigen::Vector3d& eye_world);

  const std::map<PolygonId, RegionShapePtr>& all() const { return all_; }
  const std::vector<RegionShapePtr>& shapes() const { return active_; }  ///< to be looked at, ascending by id
  /// Ids of those that went with the last frame, ascending.
  const std::vector<PolygonId>& removed() const { return removed_; }
  const Eigen::Matrix3d& R_level_world() const { return R_level_world_; }
  int IndexOf(PolygonId id) const;              ///< among those to be looked at; -1: it is not
  const RegionShape* Find(PolygonId id) const;  ///< among all; null: there is none
  /// True when the last frame changed something within reach of the shape.
  bool Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const;

 private:
  bool HoldGravity(const Gravity& gravity);
  void ReplaceChanged(const PolygonUpdate& update);
  void MakeAllAnew();
  void Put(const PolygonPtr& polygon);
  void ChooseActive(const Eigen::Vector3d& eye_level);

  RegionShapeLimits limits_;
  double max_gravity_change_rad_;
  Eigen::Matrix3d R_level_world_ = Eigen::Matrix3d::Identity();
  std::map<PolygonId, RegionShapePtr> all_;
  ShapeGrid grid_;  ///< of all
  std::vector<RegionShapePtr> active_;
  std::vector<PolygonId> removed_;
  std::vector<Eigen::AlignedBox3d> touched_;  ///< where the last frame changed something; level frame
};

}  // namespace terrace
