// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_check.h"

#include <cmath>

namespace terrace {

std::optional<std::string> ImuCheck::Read(const std::vector<ImuSample>& samples, Timestamp t_capture) {
  if (decided_ || samples.empty()) return std::nullopt;
  // The newest sample up to a frame is as old as two samples are apart.
  constexpr double kMaxAge_s = 0.5;
  const double age_s = Seconds(t_capture - samples.back().t);
  if (!t_first_ && age_s > kMaxAge_s) {
    decided_ = true;
    return "the newest sample of the IMU is " + std::to_string(age_s) +
           " s older than the images: its clock, or the unit of its time stamps, is another one";
  }
  if (!t_first_) t_first_ = samples.front().t;
  for (const ImuSample& sample : samples) {
    sum_accel_ += sample.accel;
    sum_accel_norm_ += sample.accel.norm();
    sum_rate_ += sample.gyro.norm();
  }
  num_samples_ += static_cast<int>(samples.size());
  constexpr double kEnough_s = 0.4;  // several steps of a walk would be better, but then much is built on it
  constexpr int kEnoughSamples = 20;
  if (num_samples_ < kEnoughSamples || Seconds(samples.back().t - *t_first_) < kEnough_s) return std::nullopt;
  decided_ = true;
  return Verdict();
}

std::optional<std::string> ImuCheck::Verdict() const {
  constexpr double kNothing = 0.2;       // m/s^2
  constexpr double kLeastInG = 0.5;      // g, read as m/s^2
  constexpr double kMostInG = 2.5;       // walking
  constexpr double kLeastGravity = 5.0;  // m/s^2
  constexpr double kMaxMeanRate = 12.0;      // rad/s, on the mean: two turns a second
  const double norm = sum_accel_norm_ / num_samples_;
  const double rate = sum_rate_ / num_samples_;
  if (norm < kNothing) return "the accelerometer of the IMU shows nothing, not even gravity";
  if (norm > kLeastInG && norm < kMostInG)
    return "the accelerometer of the IMU shows " + std::to_string(norm) +
           " where gravity is 9.81 m/s^2: it seems to measure in g";
  if (rate > kMaxMeanRate)
    return "the gyroscope of the IMU shows " + std::to_string(rate) +
           " rad/s on the mean: it seems to measure in degrees per second";
  const Eigen::Vector3d mean = sum_accel_ / num_samples_;
  constexpr double kOpposite = -0.5;  // cosine of 120 deg
  if (mean.norm() > kLeastGravity && mean.normalized().dot(up_imu_) < kOpposite)
    return "the accelerometer of the IMU points down where it must point up: its sign seems to be turned, or "
           "its mounting is not as T_BS says";
  return std::nullopt;
}

}  // namespace terrace
