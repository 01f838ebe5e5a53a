// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/gravity_keeper.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace terrace {

void GravityKeeper::Refine(const Eigen::Vector3d& down_world, double sigma_rad) {
  gravity_.down_world = down_world;
  gravity_.sigma_rad = sigma_rad;
}

void GravityKeeper::Take(const GravityHint& hint) {
  if (gravity_.source == GravitySource::kImu || gravity_.source == GravitySource::kAttitude) return;
  if (hint.sigma_rad >= gravity_.sigma_rad && gravity_.source != GravitySource::kAssumed) return;
  gravity_ = {hint.down_world.normalized(), hint.sigma_rad, GravitySource::kPlane};
}

void GravityKeeper::FollowAttitude(const SensorSamples& samples, const PoseEstimate& pose) {
  if (!config_.use_priors || !mounting_.T_body_left) return;
  const BodyPrior* newest = nullptr;
  for (const BodyPrior& prior : samples.priors)
    if (prior.kind == PriorKind::kAttitude) newest = &prior;
  if (!newest) return;
  constexpr double kMinSigmaRad = 0.002;
  constexpr double kDriftRad = 0.0002;  // of the pose, per frame
  constexpr double kBias = 0.8;         // share of its error that averaging cannot remove
  const double own =
      std::max(std::sqrt(0.5 * (newest->covariance(0, 0) + newest->covariance(1, 1))), kMinSigmaRad);
  const Eigen::Vector3d down_body = -(newest->T_odom_body.linear().transpose() * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d down_world =
      pose.T_world_left.linear() * (mounting_.T_body_left->linear().transpose() * down_body);
  const double before = gravity_.sigma_rad * gravity_.sigma_rad + kDriftRad * kDriftRad;
  const double gain = gravity_.source == GravitySource::kAttitude ? before / (before + own * own) : 1.0;
  gravity_.down_world = ((1.0 - gain) * gravity_.down_world + gain * down_world).normalized();
  gravity_.sigma_rad =
      std::max(std::sqrt((1.0 - gain) * before + (gain == 1.0 ? own * own : 0.0)), kBias * own);
  gravity_.source = GravitySource::kAttitude;
}

}  // namespace terrace
