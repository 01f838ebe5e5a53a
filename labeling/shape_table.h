// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "core/pose_estimate.h"
#include "labeling/region_shape.h"

namespace terrace {

/// The shapes of all regions of the map in the level frame, and where the last frame changed something.
class ShapeTable {
 public:
  /// @param max_gravity_change_rad  the level frame turns when gravity has turned by more than this
  ShapeTable(const RegionShapeLimits& limits, double max_gravity_change_rad)
      : limits_(limits), max_gravity_change_rad_(max_gravity_change_rad) {}

  void Update(const PolygonUpdate& update, const Gravity& gravity);

  const std::vector<RegionShapePtr>& shapes() const { return shapes_; }  ///< ascending by id
  const Eigen::Matrix3d& R_level_world() const { return R_level_world_; }
  int IndexOf(PolygonId id) const;  ///< -1: there is none
  /// True when the last frame changed something within reach of the shape.
  bool Touched(const RegionShape& shape, const Eigen::Vector3d& reach) const;

 private:
  void HoldGravity(const Gravity& gravity);

  RegionShapeLimits limits_;
  double max_gravity_change_rad_;
  Eigen::Matrix3d R_level_world_ = Eigen::Matrix3d::Identity();
  std::map<PolygonId, RegionShapePtr> by_id_;
  std::vector<RegionShapePtr> shapes_;
  std::vector<Eigen::AlignedBox3d> touched_;  ///< level frame
};

}  // namespace terrace
