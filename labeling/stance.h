// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "labeling/region_shape.h"

namespace terrace {

/// How a robot stands, for the search of the ground under it.
struct StanceLimits {
  double body_height_m = 0.0;
  double max_distance_m = 0.0;  ///< from the robot to the ground that it is taken to stand on
  double height_tolerance_m = 0.0;
};

/// Remembers where the robot stood. The ground under it is never in view: where it stands must go on in what
/// lies nearest at about the height of its feet, and where it once stood can be reached.
class StanceMemory {
 public:
  explicit StanceMemory(const StanceLimits& limits) : limits_(limits) {}

  /// The robot is here now. @param body_world  origin of the body
  void Stand(const Eigen::Vector3d& body_world, const Eigen::Matrix3d& R_level_world);

  /// Indices, ascending, of the supports on which the robot stands or stood.
  std::vector<int> Seeds(const std::vector<RegionShapePtr>& shapes, const Eigen::Matrix3d& R_level_world);

  /// True when the last Seeds() found ground at the height of the feet, where the robot is or where it was;
  /// else they are a guess.
  bool at_feet() const { return at_feet_; }

 private:
  struct Stance {
    Eigen::Vector3d ground_world = Eigen::Vector3d::Zero();
    PolygonId ground = 0;  ///< 0: none found yet
  };
  StanceLimits limits_;
  bool at_feet_ = false;
  std::vector<Stance> past_;  ///< thinned out; the last one is where the robot is now
};

}  // namespace terrace
