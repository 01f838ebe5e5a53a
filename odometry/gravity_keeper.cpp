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
  const bool by_attitude =
      gravity_.source == GravitySource::kAttitude && followed_ != Followed::kLegs && !attitude_refused_;
  if (gravity_.source == GravitySource::kImu || by_attitude) return;
  if (hint.sigma_rad >= gravity_.sigma_rad && gravity_.source != GravitySource::kAssumed) return;
  gravity_ = {hint.down_world.normalized(), hint.sigma_rad, GravitySource::kPlane};
}

void GravityKeeper::FollowAttitude(const SensorSamples& samples, const PoseEstimate& pose) {
  if (!config_.use_priors || !mounting_.T_body_left) return;
  const BodyPrior* attitude = nullptr;
  const BodyPrior* legs = nullptr;
  for (const BodyPrior& prior : samples.priors)
    (prior.kind == PriorKind::kAttitude ? attitude : legs) = &prior;
  constexpr double kLeastAttitudeRad = 0.002, kLeastLegsRad = 0.0175;
  if (attitude) {
    const Down down = DownSaidBy(*attitude, kLeastAttitudeRad, pose);
    if (Believes(down)) Follow(down, Followed::kAttitude);
  }
  // Legs know roll and pitch, too, where nothing knows them better.
  const bool known_better =
      gravity_.source == GravitySource::kPlane ||
      (gravity_.source == GravitySource::kAttitude && followed_ == Followed::kAttitude && !attitude_refused_);
  if (legs && !known_better) Follow(DownSaidBy(*legs, kLeastLegsRad, pose), Followed::kLegs);
}

GravityKeeper::Down GravityKeeper::DownSaidBy(const BodyPrior& prior, double least_sigma_rad,
                                              const PoseEstimate& pose) const {
  const Eigen::Vector3d down_body = -(prior.T_odom_body.linear().transpose() * Eigen::Vector3d::UnitZ());
  return {pose.T_world_left.linear() * (mounting_.T_body_left->linear().transpose() * down_body),
          std::max(std::sqrt(0.5 * (prior.covariance(0, 0) + prior.covariance(1, 1))), least_sigma_rad)};
}

void GravityKeeper::Follow(const Down& said, Followed by) {
  constexpr double kDriftRad = 0.0002;  // of the pose, per frame
  constexpr double kBias = 0.8;         // share of its error that averaging cannot remove
  const double before = gravity_.sigma_rad * gravity_.sigma_rad + kDriftRad * kDriftRad;
  const double own = said.sigma_rad;
  const bool goes_on =
      gravity_.source == GravitySource::kAttitude && (followed_ == by || followed_ == Followed::kNobody);
  const double gain = goes_on ? before / (before + own * own) : 1.0;
  gravity_.down_world = ((1.0 - gain) * gravity_.down_world + gain * said.down_world).normalized();
  gravity_.sigma_rad =
      std::max(std::sqrt((1.0 - gain) * before + (gain == 1.0 ? own * own : 0.0)), kBias * own);
  gravity_.source = GravitySource::kAttitude;
  followed_ = by;
}

/// What turns with the body as the images show it stays where it is in the world.
bool GravityKeeper::Believes(const Down& said) {
  if (gravity_.source != GravitySource::kAttitude && !attitude_refused_) return true;
  constexpr double kMostSigmas = 5.0;
  constexpr int kMostContradictions = 10, kEnoughAgreement = 30;  // readings
  const double off_rad = std::acos(std::clamp(said.down_world.dot(gravity_.down_world), -1.0, 1.0));
  const bool can_be = off_rad < kMostSigmas * std::hypot(gravity_.sigma_rad, said.sigma_rad);
  if (attitude_refused_) {
    num_agreed_ = can_be ? num_agreed_ + 1 : 0;
    if (num_agreed_ < kEnoughAgreement) return false;
    attitude_refused_ = false;
    num_contradictions_ = num_agreed_ = 0;
    warning_ = "the body attitude agrees with the images again and is used";
    return true;
  }
  num_contradictions_ = std::max(0, num_contradictions_ + (can_be ? -1 : 1));
  if (num_contradictions_ == kMostContradictions) {
    attitude_refused_ = true;
    warning_ = Printed(
        "the body attitude is %.0f deg from where the images have carried it: it is not used until they "
        "agree",
        off_rad * 180.0 / M_PI);
  }
  return can_be;
}

}  // namespace terrace
