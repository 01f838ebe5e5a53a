// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/gravity_keeper.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/print.h"

namespace terrace {

void GravityKeeper::Refine(const Eigen::Vector3d& down_world, double sigma_rad) {
  gravity_.down_world = down_world;
  gravity_.sigma_rad = sigma_rad;
}

void GravityKeeper::Take(const GravityHint& hint) {
  const bool by_attitude = gravity_.source == GravitySource::kAttitude && !from_legs_ && !attitude_refused_;
  if (gravity_.source == GravitySource::kImu || by_attitude) return;
  if (hint.sigma_rad >= gravity_.sigma_rad && gravity_.source != GravitySource::kAssumed) return;
  gravity_ = {hint.down_world.normalized(), hint.sigma_rad, GravitySource::kPlane};
}

void GravityKeeper::FollowAttitude(const SensorSamples& samples, const PoseEstimate& pose) {
  if (!config_.use_priors || !mounting_.T_body_left) return;
  // Legs know roll and pitch, too, where nothing knows them better.
  const BodyPrior* newest = nullptr;
  for (const PriorKind kind : {PriorKind::kLegOdometry, PriorKind::kAttitude})
    for (const BodyPrior& prior : samples.priors)
      if (prior.kind == kind && !(kind == PriorKind::kAttitude && attitude_refused_)) newest = &prior;
  if (!newest) return;
  const bool by_legs = newest->kind == PriorKind::kLegOdometry;
  if (by_legs && gravity_.source == GravitySource::kPlane) return;
  const double least_sigma_rad = by_legs ? 0.0175 : 0.002;
  constexpr double kDriftRad = 0.0002;  // of the pose, per frame
  constexpr double kBias = 0.8;         // share of its error that averaging cannot remove
  const double own =
      std::max(std::sqrt(0.5 * (newest->covariance(0, 0) + newest->covariance(1, 1))), least_sigma_rad);
  const Eigen::Vector3d down_body = -(newest->T_odom_body.linear().transpose() * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d down_world =
      pose.T_world_left.linear() * (mounting_.T_body_left->linear().transpose() * down_body);
  if (!Believes(down_world, own)) return;
  const double before = gravity_.sigma_rad * gravity_.sigma_rad + kDriftRad * kDriftRad;
  const double gain = gravity_.source == GravitySource::kAttitude ? before / (before + own * own) : 1.0;
  gravity_.down_world = ((1.0 - gain) * gravity_.down_world + gain * down_world).normalized();
  gravity_.sigma_rad =
      std::max(std::sqrt((1.0 - gain) * before + (gain == 1.0 ? own * own : 0.0)), kBias * own);
  gravity_.source = GravitySource::kAttitude;
  from_legs_ = by_legs;
}

/// What turns with the body as the images show it stays where it is in the world.
bool GravityKeeper::Believes(const Eigen::Vector3d& down_world, double sigma_rad) {
  if (gravity_.source != GravitySource::kAttitude) return true;
  constexpr double kMostSigmas = 5.0;
  constexpr int kMostContradictions = 10;
  const double off_rad = std::acos(std::clamp(down_world.dot(gravity_.down_world), -1.0, 1.0));
  const bool can_be = off_rad < kMostSigmas * std::hypot(gravity_.sigma_rad, sigma_rad);
  num_contradictions_ = std::max(0, num_contradictions_ + (can_be ? -1 : 1));
  if (num_contradictions_ == kMostContradictions && !std::exchange(attitude_refused_, true)) {
    warning_ = Printed(
        "the body attitude is %.0f deg from where the images have carried it: it is not used any more",
        off_rad * 180.0 / M_PI);
  }
  return can_be;
}

}  // namespace terrace
