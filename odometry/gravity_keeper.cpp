// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/gravity_keeper.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "core/print.h"

namespace terrace {
namespace {

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

}  // namespace

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
  std::optional<Down> by_attitude, by_legs;
  if (attitude) by_attitude = DownSaidBy(*attitude, kLeastAttitudeRad, pose);
  if (legs) by_legs = DownSaidBy(*legs, kLeastLegsRad, pose);
  if (by_attitude && by_legs) Compare(*by_attitude, *by_legs);
  if (by_attitude && Believes(*by_attitude)) Follow(*by_attitude, Followed::kAttitude);
  // Legs know roll and pitch, too, where nothing knows them better.
  const bool known_better =
      gravity_.source == GravitySource::kPlane ||
      (gravity_.source == GravitySource::kAttitude && followed_ == Followed::kAttitude && !attitude_refused_);
  if (by_legs && !known_better && !legs_refused_) Follow(*by_legs, Followed::kLegs);
}

/// Both turn as the images show, and yet lean apart: one of them is mounted or computed wrongly. A robot is
/// started standing level more often than not, so the one is believed that says so rather.
void GravityKeeper::Compare(const Down& by_attitude, const Down& by_legs) {
  if (attitude_refused_ || legs_refused_) return;
  constexpr double kMostSigmas = 5.0, kLeast_rad = 5.0 * M_PI / 180.0;
  constexpr int kMostApart = 10;  // frames
  const double off_rad = AngleBetween(by_attitude.down_world, by_legs.down_world);
  const bool apart =
      off_rad > std::max(kLeast_rad, kMostSigmas * std::hypot(by_attitude.sigma_rad, by_legs.sigma_rad));
  num_apart_ = apart ? num_apart_ + 1 : std::max(0, num_apart_ - 1);
  if (num_apart_ < kMostApart) return;
  num_apart_ = 0;
  legs_refused_ =
      AngleBetween(by_attitude.down_world, down_if_level_) < AngleBetween(by_legs.down_world, down_if_level_);
  attitude_refused_ = !legs_refused_;
  num_agreed_ = 0;
  const std::string apart_by =
      Printed("the body attitude leans %.0f deg from the legs' roll and pitch: ", off_rad * 180.0 / M_PI);
  warning_ = apart_by + (legs_refused_ ? "the legs' are not used" : "it is not used until they agree") +
             ", as the other is nearer to a robot that was started standing level";
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
  const double off_rad = AngleBetween(said.down_world, gravity_.down_world);
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
