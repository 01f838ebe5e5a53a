// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/bridging.h"

#include "odometry/covariance.h"

namespace terrace {

void Bridging::See(const PoseEstimate& pose) {
  T_world_seen_ = pose.T_world_left;
  seen_covariance_ = pose.covariance;
  bridged_s_ = 0.0;
  covariance_.setZero();
}

PoseEstimate Bridging::Extend(const PoseEstimate& last, const Motion& predicted,
                              const std::function<Matrix6d(double)>& drift_after) {
  bridged_s_ += predicted.dt_s;
  PoseEstimate pose;
  pose.T_world_left = last.T_world_left * predicted.T_last_left;
  pose.T_prev_left = predicted.T_last_left;
  if (predicted.by_legs) {
    pose.covariance_prev = predicted.covariance;
    pose.covariance = TransportCovariance(predicted.T_last_left, last.covariance) + predicted.covariance;
  } else {
    // An error of the velocity goes on: it grows with the time, not with its root.
    const Matrix6d drift = drift_after(bridged_s_);
    const Matrix6d before = drift_after(bridged_s_ - predicted.dt_s);
    pose.covariance =
        TransportCovariance(T_world_seen_.inverse() * pose.T_world_left, seen_covariance_) + drift;
    const Vector6d step = drift.diagonal().cwiseSqrt() - before.diagonal().cwiseSqrt();
    pose.covariance_prev = step.cwiseAbs2().asDiagonal();
  }
  covariance_ = SearchCovariance(predicted);
  return pose;
}

Matrix6d Bridging::SearchCovariance(const Motion& predicted) const {
  return TransportCovariance(predicted.T_last_left, covariance_) + predicted.covariance;
}

}  // namespace terrace
