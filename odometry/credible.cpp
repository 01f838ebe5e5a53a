// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/credible.h"

namespace terrace {
namespace {

/// Twice what the IMUs of robots can measure (16 g, 2000 deg/s), and more than a foot strike makes.
constexpr double kMaxAcceleration = 320.0;  // m/s^2
constexpr double kMaxRate = 70.0;           // rad/s

bool IsReading(const ImuSample& sample) {
  return sample.accel.allFinite() && sample.gyro.allFinite() && sample.accel.norm() < kMaxAcceleration &&
         sample.gyro.norm() < kMaxRate;
}

bool IsReading(const BodyPrior& prior) {
  return IsPose(prior.T_odom_body) && prior.covariance.allFinite() &&
         (prior.covariance.diagonal().array() >= 0.0).all();
}

}  // namespace

SensorSamples Credible(const SensorSamples& samples, int* num_dropped) {
  SensorSamples credible;
  credible.imu.reserve(samples.imu.size());
  for (const ImuSample& sample : samples.imu)
    if (IsReading(sample)) credible.imu.push_back(sample);
  for (const BodyPrior& prior : samples.priors)
    if (IsReading(prior)) credible.priors.push_back(prior);
  *num_dropped += static_cast<int>(samples.imu.size() + samples.priors.size() - credible.imu.size() -
                                   credible.priors.size());
  return credible;
}

bool IsPose(const Eigen::Isometry3d& pose) {
  constexpr double kRounding = 1e-6;
  const Eigen::Matrix3d& R = pose.linear();
  return pose.matrix().allFinite() && (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < kRounding &&
         R.determinant() > 0.0;
}

}  // namespace terrace
