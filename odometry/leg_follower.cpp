// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/leg_follower.h"

#include <cmath>
#include <utility>

#include "core/print.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

constexpr double kMoving_m = 0.01;  // in a frame

}  // namespace

bool LegFollower::unproven() const {
  constexpr int kProof = 15;  // frames
  return said_m_ > kMoving_m && num_agreed_moving_ < kProof;
}

void LegFollower::Read(const std::vector<BodyPrior>& priors) {
  step_.reset();
  said_m_ = 0.0;
  bool can_be = true;
  for (const BodyPrior& prior : priors) {
    if (prior.kind != PriorKind::kLegOdometry) continue;
    if (newest_) {
      const Eigen::Isometry3d step = newest_->T_odom_body.inverse() * prior.T_odom_body;
      can_be = can_be && CanBe(*newest_, prior);
      said_m_ += step.translation().norm();
      // Covariances that grow are those of the whole way so far.
      const Matrix6d growth = prior.covariance - newest_->covariance;
      const bool of_the_way = (growth.diagonal().array() >= 0.0).all() && growth.diagonal().sum() > 0.0;
      const Matrix6d of_step = of_the_way ? growth : prior.covariance;
      if (!step_) {
        step_ = prior;
        step_->T_odom_body = step;
        step_->covariance = of_step;
      } else {
        step_->T_odom_body = step_->T_odom_body * step;
        step_->covariance = of_the_way ? Matrix6d(step_->covariance + of_step) : of_step;
      }
    }
    newest_ = prior;
  }
  jumped_before_ = std::exchange(jumped_, !can_be);
  if (jumped_) step_.reset();
}

bool LegFollower::CanBe(const BodyPrior& from, const BodyPrior& to) const {
  constexpr double kSlack_m = 0.2, kSlack_rad = 0.1;
  constexpr double kMaxRate = 6.0;  // rad/s: no body on legs turns faster
  const double dt_s = Seconds(to.t - from.t);
  const Eigen::Isometry3d step = from.T_odom_body.inverse() * to.T_odom_body;
  return step.translation().norm() < kSlack_m + max_speed_mps_ * dt_s &&
         LogRotation(step.linear()).norm() < kSlack_rad + kMaxRate * dt_s;
}

void LegFollower::Compare(const Eigen::Isometry3d& T_before_body) {
  if (!newest_) return;
  const double seen_m = T_before_body.translation().norm();
  constexpr double kMuch_m = 1.0;  // in one frame
  if (!step_ && said_m_ > kMuch_m && !std::exchange(jump_told_, true))
    warning_ =
        Printed("leg odometry jumps by %.1f m from one frame to the next: such steps are left out", said_m_);
  CompareLengths(seen_m);
  constexpr int kEnough = 30;  // frames
  constexpr double kAgree_m = 0.01, kAgreeShare = 0.25;
  const bool agrees = step_ && (step_->T_odom_body.translation() - T_before_body.translation()).norm() <
                                   kAgree_m + kAgreeShare * seen_m;
  num_agreed_ = agrees ? num_agreed_ + 1 : 0;
  if (agrees && said_m_ > kMoving_m) ++num_agreed_moving_;
  if (!refused_ || num_agreed_ < kEnough) return;
  refused_ = false;
  warning_ = "leg odometry agrees with the images again and is used";
}

/// Units and gears are wrong in every step by the same factor.
void LegFollower::CompareLengths(double seen_m) {
  constexpr double kEnough_m = 0.3;
  constexpr double kMostFactor = 1.5;
  if (jumped_ && !jumped_before_) return;  // a jump, and no unit
  seen_path_m_ += seen_m;
  said_path_m_ += said_m_;
  if (seen_path_m_ < kEnough_m || length_told_) return;
  const double factor = said_path_m_ / seen_path_m_;
  seen_path_m_ = said_path_m_ = 0.0;
  if (factor < kMostFactor && factor > 1.0 / kMostFactor) return;
  length_told_ = true;
  refused_ = true;
  num_agreed_ = 0;
  std::string unit;
  if (factor > 700.0 && factor < 1400.0) unit = ": it seems to be in millimetres";
  if (factor > 70.0 && factor < 140.0) unit = ": it seems to be in centimetres";
  warning_ =
      Printed("leg odometry goes %.3g times as far as the images show%s; it is not used until they agree",
              factor, unit.c_str());
}

void LegFollower::Refuse() {
  refused_ = true;
  num_agreed_ = 0;
  warning_ = "leg odometry contradicts the images: do the feet slip? It is not used until they agree";
}

void LegFollower::Restart() {
  newest_.reset();
  step_.reset();
}

std::optional<std::string> LegFollower::TakeWarning() { return std::exchange(warning_, std::nullopt); }

}  // namespace terrace
