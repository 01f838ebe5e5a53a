// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/witness.h"

#include <algorithm>
#include <cmath>

#include "odometry/covariance.h"

namespace terrace {
namespace {

/// Of six components. Seven standard deviations of one: undamaged walks stay below one.
constexpr double kMostChi2 = 50.0;
constexpr double kApartOver_s = 1.0;
constexpr int kProofFrames = 15;  // frames
constexpr int kAgainFrames = 5;   // frames: what is wrong agrees now and then

}  // namespace

bool Witness::proven() const { return num_agreed_ >= kProofFrames; }

Witness::Verdict Witness::Hear(const Vector6d& error, const Matrix6d& covariance, double dt_s) {
  const bool possible = Chi2(error, covariance) <= kMostChi2;
  num_agreed_ += possible;
  if (!proven()) return Verdict::kAgrees;
  contradicts_ = !possible;
  error_ = error;
  Vector6d turn = Vector6d::Zero(), shift = Vector6d::Zero();
  turn.head<3>() = error.head<3>();
  shift.tail<3>() = error.tail<3>();
  const double turn_chi2 = Chi2(turn, covariance);
  turns_otherwise_ = turn_chi2 > kMostChi2 && turn_chi2 > Chi2(shift, covariance);
  if (contradicts_) {
    disagreed_s_ += dt_s;
    num_agreed_again_ = 0;
    return Verdict::kContradicts;
  }
  const double keep = std::exp(-dt_s / kApartOver_s);
  apart_ = keep * apart_ + error;
  apart_covariance_ = keep * keep * apart_covariance_ + covariance;
  const bool apart = Chi2(apart_, apart_covariance_) > kMostChi2;
  num_agreed_again_ = apart ? 0 : std::min(num_agreed_again_ + 1, kAgainFrames);
  const bool settled = disagreed_s_ == 0.0 || num_agreed_again_ == kAgainFrames;
  disagreed_s_ = !apart && settled ? 0.0 : disagreed_s_ + dt_s;
  if (apart) return Verdict::kDriftsApart;
  return settled ? Verdict::kAgrees : Verdict::kAgreesAgain;
}

}  // namespace terrace
