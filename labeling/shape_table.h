// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/pose_estimate.h"
#include "labeling/region_shape.h"

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

  const std::vector<RegionShapePtr>& all() const { return all_; }        ///< ascending by id
  const std::vector<RegionShapePtr>& shapes() const { return active_; }  ///< to be looked at, ascending by id
  const Eigen::Matrix3d& R_level_world() const { return R_level_world_; }
  int IndexOf(PolygonId id) const;              ///< among those to be looked at; -1: it is not
  const RegionShape* Find(PolygonId id) const;  ///< among all; null: there is none
  /// True when the last frame changed something within reach of the shape.
  bool Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const;

 private:
  bool HoldGravity(const Gravity& gravity);
  void ReplaceChanged(const PolygonUpdate& update, bool all_anew);
  void ChooseActive(const Eigen::Vector3d& eye_level);

  RegionShapeLimits limits_;
  double max_gravity_change_rad_;
  Eigen::Matrix3d R_level_world_ = Eigen::Matrix3d::Identity();
  std::vector<RegionShapePtr> all_;
  std::vector<RegionShapePtr> active_;
  std::vector<Eigen::AlignedBox3d> touched_;  ///< where the last frame changed something; level frame
};

}  // namespace terrace
