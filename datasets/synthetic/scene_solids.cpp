// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_solids.h"

namespace terrace::synthetic {
namespace {

/// What rises this far is a wall (DESIGN.md, "Labels").
constexpr double kWallHeight_m = 1.0;

}  // namespace

std::string UprightLabel(double height_m) { return height_m >= kWallHeight_m ? "wall" : "obstacle"; }

Eigen::Isometry3d GroundFrame(const Eigen::Vector3d& origin, double yaw_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = origin;
  T.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T;
}

Ring Placed(const Eigen::Isometry3d& T_world_frame, const std::vector<Eigen::Vector3d>& corners) {
  Ring ring;
  for (const Eigen::Vector3d& corner : corners) ring.push_back(T_world_frame * corner);
  return ring;
}

}  // namespace terrace::synthetic
