// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/bridging.h"

#include <algorithm>
#include <limits>

#include "odometry/covariance.h"
#include "odometry/rotation.h"

namespace terrace {

void Bridging::See(const PoseEstimate& pose) {
  T_world_seen_ = pose.T_world_left;
  seen_covariance_ = pose.covariance;
  bridged_s_ = 0.0;
  num_steps_ = 0;
  covariance_.setZero();
  drift_.setZero();
}

PoseEstimate Bridging::Extend(const PoseEstimate& last, const Motion& predicted,
                              const std::function<Matrix6d(double)>& drift_after) {
  bridged_s_ += predicted.dt_s;
  PoseEstimate pose;
  pose.T_world_left = Chained(last.T_world_left, predicted.T_last_left);
  pose.T_prev_left = predicted.T_last_left;
  if (predicted.by_legs) {
    pose.covariance_prev = predicted.covariance;
    drift_ = TransportCovariance(predicted.T_last_left, drift_) + predicted.covariance;
    pose.covariance = TransportCovariance(predicted.T_last_left, last.covariance) + predicted.covariance;
  } else {
    // An error of the velocity goes on: it grows with the time, not with its root.
    const Matrix6d drift = drift_after(bridged_s_);
    drift_ = drift;
    const Matrix6d before = drift_after(bridged_s_ - predicted.dt_s);
    pose.covariance =
        TransportCovariance(T_world_seen_.inverse() * pose.T_world_left, seen_covariance_) + drift;
    const Vector6d step = drift.diagonal().cwiseSqrt() - before.diagonal().cwiseSqrt();
    pose.covariance_prev = step.cwiseAbs2().asDiagonal();
  }
  covariance_ = SearchCovariance(predicted);
  ++num_steps_;
  return pose;
}

PoseEstimate Bridging::Hold(const PoseEstimate& last, double dt_s) {
  bridged_s_ += std::max(dt_s, 0.0);
  PoseEstimate pose;
  pose.T_world_left = last.T_world_left;
  pose.covariance = last.covariance;
  return pose;
}

void Bridging::LoseTime() { bridged_s_ = std::numeric_limits<double>::infinity(); }

bool Bridging::CanReach(const Eigen::Isometry3d& T_world_left,
                        const Eigen::Isometry3d& bridged_T_world_left) const {
  constexpr double kMaxChi2 = 40.0;  // of six components; generous, as the motion is only presumed
  // What one step is wrong by, the next one is wrong by, too: errors add up, not their squares.
  const Matrix6d whole = num_steps_ * covariance_;
  return Chi2(StepBetween(bridged_T_world_left, T_world_left), whole) < kMaxChi2;
}

Matrix6d Bridging::ExpectedCovariance(const Motion& predicted) const {
  return TransportCovariance(predicted.T_last_left, drift_) + predicted.covariance;
}

Matrix6d Bridging::SearchCovariance(const Motion& predicted) const {
  return TransportCovariance(predicted.T_last_left, covariance_) + predicted.covariance;
}

}  // namespace terrace
