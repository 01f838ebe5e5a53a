// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "datasets/synthetic/scene.h"

namespace terrace::synthetic {

/// Position, velocity, turn rate and acceleration of the body at one moment.
struct BodyState {
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d a_world = Eigen::Vector3d::Zero();     ///< without gravity
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();  ///< rad/s
};

/// How the body moves: uniform cubic B-splines of x, y, z, roll, pitch and yaw. Velocity, acceleration and
/// turn rate are their exact derivatives, so that an IMU and the poses never disagree.
class Trajectory {
 public:
  /// @param controls  x y z [m], roll pitch yaw [rad] every `step_s`; the first belongs to -step_s
  Trajectory(std::vector<Vector6d> controls, double step_s, double duration_s, std::vector<double> strikes_s);

  double duration_s() const { return duration_s_; }
  BodyState At(double t_s) const;
  Eigen::Isometry3d PoseAt(double t_s) const { return At(t_s).T_world_body; }
  /// Moments at which feet hit the ground, ascending.
  const std::vector<double>& strikes_s() const { return strikes_s_; }

 private:
  std::vector<Vector6d> controls_;
  double step_s_;
  double duration_s_;
  std::vector<double> strikes_s_;
};

/// Height of the ground below a point, or NaN: where feet would stand.
using GroundHeight = std::function<double(const Eigen::Vector3d& from)>;

/// Moves a six-legged robot as the plan says: two tripods of legs in turn, so that the body bounces and
/// pitches with every step and rolls with every second, jolts where feet hit, and rises with the ground under
/// the feet.
Trajectory PlanMotion(const MotionPlan& plan, const Mounting& mounting, const GroundHeight& ground,
                      std::uint32_t seed);

}  // namespace terrace::synthetic
