// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/pose_estimate.h"
#include "odometry/gravity_keeper.h"
#include "polygonization/polygon.h"

namespace terrace {

/// A better "up" from what the robot walks on: the mean normal, weighed by information, of the large planes
/// that lie within a few degrees of level (within 45 deg of the camera's -y while up is only assumed). A hint
/// about levelness only: it cannot tell a slope from a leaning world, so its sigma is never better than
/// floors are level.
class LevelPlanes {
 public:
  void Update(const PolygonUpdate& update);
  /// As of the last update; none when there is no such plane.
  std::optional<GravityHint> Hint(const Gravity& gravity) const;

 private:
  /// What a large polygon says, side by side in memory: all are gone through in every frame.
  struct LargePlane {
    PolygonId id = 0;
    Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();
    double area_m2 = 0.0;
    double tilt_variance = 0.0;
  };
  std::vector<LargePlane> planes_;  ///< ascending by id
  FrameId frame_id_ = 0;
};

}  // namespace terrace
