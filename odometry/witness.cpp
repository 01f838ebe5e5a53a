// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/witness.h"

#include <cmath>

#include "odometry/covariance.h"

namespace terrace {
namespace {

/// Of six components. Seven standard deviations of one: undamaged walks stay below one.
constexpr double kMostChi2 = 50.0;
constexpr double kMemory_s = 1.0;
constexpr int kProof = 15;  // frames

}  // namespace

Witness::Verdict Witness::Hear(const Vector6d& error, const Matrix6d& covariance, double dt_s) {
  const bool possible = Chi2(error, covariance) <= kMostChi2;
  num_agreed_ += possible;
  if (num_agreed_ < kProof) return Verdict::kAgrees;
  contradicts_ = !possible;
  if (contradicts_) {
    disagreed_s_ += dt_s;
    return Verdict::kContradicts;
  }
  const double keep = std::exp(-dt_s / kMemory_s);
  apart_ = keep * apart_ + error;
  apart_covariance_ = keep * keep * apart_covariance_ + covariance;
  const bool apart = Chi2(apart_, apart_covariance_) > kMostChi2;
  disagreed_s_ = apart ? disagreed_s_ + dt_s : 0.0;
  return apart ? Verdict::kDriftsApart : Verdict::kAgrees;
}

}  // namespace terrace
