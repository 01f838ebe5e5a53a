// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/sensors.h"

#include <algorithm>
#include <cmath>

#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

constexpr double kGravity = 9.81;
constexpr int kCurveSteps = 1 << 14;
constexpr int kQuantiles = 1 << 12;

double Srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Values of a normal distribution, equally likely: one table look-up a pixel instead of logarithms.
const std::vector<float>& NormalQuantiles() {
  static const std::vector<float> table = [] {
    std::vector<float> quantiles(kQuantiles);
    for (int i = 0; i < kQuantiles; ++i) {
      // Bisection on the distribution function; run once.
      const double p = (i + 0.5) / kQuantiles;
      double low = -6.0;
      double high = 6.0;
      for (int step = 0; step < 50; ++step) {
        const double x = 0.5 * (low + high);
        (0.5 * std::erfc(-x / std::sqrt(2.0)) < p ? low : high) = x;
      }
      quantiles[static_cast<std::size_t>(i)] = static_cast<float>(0.5 * (low + high));
    }
    return quantiles;
  }();
  return table;
}

Timestamp TimeOf(Timestamp t_start, int index, double rate_hz) {
  return {t_start.ns + static_cast<std::int64_t>(std::llround(index * 1e9 / rate_hz))};
}

int CountOf(const Trajectory& trajectory, double rate_hz) {
  return static_cast<int>(std::floor(trajectory.duration_s() * rate_hz + 1e-6)) + 1;
}

Eigen::Vector3d Gaussian3(Random& random, double sigma) {
  const double x = random.Gaussian();
  const double y = random.Gaussian();
  const double z = random.Gaussian();
  return sigma * Eigen::Vector3d(x, y, z);
}

Eigen::Quaterniond Small(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  if (angle < 1e-15) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation / angle));
}

}  // namespace

ImageSensor::ImageSensor(const Photometry& photometry) : photometry_(photometry), curve_(kCurveSteps + 1) {
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double grey =
        photometry_.black + (255.0 - photometry_.black) * Srgb(static_cast<double>(i) / kCurveSteps);
    curve_[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
  }
}

double ImageSensor::VignetteAt(int x, int y, int width, int height) const {
  const double cx = 0.5 * (width - 1);
  const double cy = 0.5 * (height - 1);
  const double square = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (cx * cx + cy * cy);
  return 1.0 - photometry_.vignette * square;
}

double ImageSensor::MeanOf(const Radiance& light) const {
  double sum = 0.0;
  for (int y = 0; y < light.height; y += 2) {
    for (int x = 0; x < light.width; x += 2) {
      sum += light.data[static_cast<std::size_t>(y) * static_cast<std::size_t>(light.width) +
                        static_cast<std::size_t>(x)] *
             VignetteAt(x, y, light.width, light.height);
    }
  }
  return sum / (((light.width + 1) / 2) * ((light.height + 1) / 2));
}

GrayImage ImageSensor::Expose(const Radiance& light, double gain, std::uint32_t seed) const {
  const std::vector<float>& normal = NormalQuantiles();
  GrayImage image{light.width, light.height, std::vector<std::uint8_t>(light.data.size())};
  const double well = photometry_.full_well;
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(light.width) + static_cast<std::size_t>(x);
      const double clean = std::min(gain * light.data[i] * VignetteAt(x, y, light.width, light.height), 4.0);
      // Shot noise has the variance of the number of electrons.
      const double sigma = std::sqrt(clean * well + photometry_.read_noise * photometry_.read_noise) / well;
      const double noisy = clean + sigma * normal[Hash(seed, static_cast<std::uint32_t>(i)) >> 20];
      const auto step = static_cast<std::size_t>(std::clamp(noisy, 0.0, 1.0) * kCurveSteps + 0.5);
      image.data[i] = curve_[step];
    }
  }
  return image;
}

AutoExposure::AutoExposure(double target, double speed_hz, double rate_hz)
    : target_(target), speed_(1.0 - std::exp(-speed_hz / rate_hz)) {}

double AutoExposure::GainFor(double mean) {
  const double right = target_ / std::max(mean, 1e-6);
  if (next_gain_ <= 0.0) next_gain_ = right;
  gain_ = next_gain_;
  next_gain_ = gain_ * std::pow(right / gain_, speed_);
  return gain_;
}

ImuSample PerfectImu(const Trajectory& trajectory, double t_s, Timestamp t) {
  const BodyState state = trajectory.At(t_s);
  const Eigen::Vector3d force_world = state.a_world + Eigen::Vector3d(0, 0, kGravity);
  return {t, state.omega_body, state.T_world_body.rotation().transpose() * force_world};
}

std::vector<ImuRecord> SimulateImu(const Trajectory& trajectory, const ImuNoise& noise, double rate_hz,
                                   Timestamp t_start, std::uint32_t seed) {
  Random random(Hash(seed, 21));
  constexpr double kGyroBias = 0.003;  // rad/s, at the start
  constexpr double kAccelBias = 0.03;  // m/s^2
  Eigen::Vector3d gyro_bias = Gaussian3(random, kGyroBias);
  Eigen::Vector3d accel_bias = Gaussian3(random, kAccelBias);
  std::vector<ImuRecord> records;
  for (int i = 0; i < CountOf(trajectory, rate_hz); ++i) {
    ImuSample sample = PerfectImu(trajectory, i / rate_hz, TimeOf(t_start, i, rate_hz));
    sample.gyro += gyro_bias + Gaussian3(random, noise.gyro_density * std::sqrt(rate_hz));
    sample.accel += accel_bias + Gaussian3(random, noise.accel_density * std::sqrt(rate_hz));
    records.push_back({sample, gyro_bias, accel_bias});
    gyro_bias += Gaussian3(random, noise.gyro_walk / std::sqrt(rate_hz));
    accel_bias += Gaussian3(random, noise.accel_walk / std::sqrt(rate_hz));
  }
  return records;
}

std::vector<PriorRecord> SimulateAttitude(const Trajectory& trajectory, double rate_hz, Timestamp t_start,
                                          std::uint32_t seed) {
  Random random(Hash(seed, 22));
  constexpr double kSigma = 0.0087;   // rad, of roll and pitch
  constexpr double kMemory_s = 8.0;   // for which an error lasts
  constexpr double kYawWalk = 0.004;  // rad / sqrt(s)
  const double keep = std::exp(-1.0 / (rate_hz * kMemory_s));
  Eigen::Vector3d error = Gaussian3(random, kSigma);
  error.z() = 0.0;
  std::vector<PriorRecord> records;
  for (int i = 0; i < CountOf(trajectory, rate_hz); ++i) {
    PriorRecord record;
    record.t = TimeOf(t_start, i, rate_hz);
    const Eigen::Matrix3d R = trajectory.PoseAt(i / rate_hz).rotation();
    record.T_odom_body.linear() = (Small(error) * Eigen::Quaterniond(R)).toRotationMatrix();
    record.rotation_sigma_rad = {kSigma, kSigma, 0.02 + kYawWalk * std::sqrt(i / rate_hz)};
    records.push_back(record);
    const Eigen::Vector3d push = Gaussian3(random, 1.0);
    error.head<2>() = keep * error.head<2>() + kSigma * std::sqrt(1.0 - keep * keep) * push.head<2>();
    error.z() += kYawWalk / std::sqrt(rate_hz) * push.z();
  }
  return records;
}

std::vector<PriorRecord> SimulateLegs(const Trajectory& trajectory, double rate_hz, Timestamp t_start,
                                      std::uint32_t seed) {
  Random random(Hash(seed, 23));
  constexpr double kDrift = 0.03;      // of the way
  constexpr double kTurnDrift = 0.03;  // of the turn
  constexpr double kSlip_m = 0.003;    // at a strike
  constexpr double kSlip_rad = 0.003;
  const double scale = 1.0 + kDrift;
  std::vector<PriorRecord> records;
  Eigen::Isometry3d T_world_body = trajectory.PoseAt(0.0);
  // Its own frame: where the body stands first, level, its yaw zero.
  Eigen::Isometry3d T_odom_body = Eigen::Isometry3d::Identity();
  const Eigen::Matrix3d R0 = T_world_body.rotation();
  const double yaw0 = std::atan2(R0(1, 0), R0(0, 0));
  T_odom_body.linear() = Eigen::AngleAxisd(-yaw0, Eigen::Vector3d::UnitZ()).toRotationMatrix() * R0;
  std::size_t strike = 0;
  double translation_variance = 1e-8;
  double rotation_variance = 1e-8;
  for (int i = 0; i < CountOf(trajectory, rate_hz); ++i) {
    const double t = i / rate_hz;
    const Eigen::Isometry3d now = trajectory.PoseAt(t);
    const Eigen::Isometry3d step = T_world_body.inverse() * now;
    const Eigen::AngleAxisd turn(step.rotation());
    Eigen::Vector3d way = scale * step.translation();
    Eigen::Vector3d rotation = turn.angle() * turn.axis();
    // Roll and pitch come from gravity and do not drift; what is turned too far is yaw.
    rotation.z() *= 1.0 + kTurnDrift;
    translation_variance += std::pow(kDrift, 2) * step.translation().squaredNorm();
    rotation_variance += std::pow(kTurnDrift * turn.angle(), 2);
    for (; strike < trajectory.strikes_s().size() && trajectory.strikes_s()[strike] <= t; ++strike) {
      // One slip in eight is a bad one.
      const double force = random.Uniform() < 0.125 ? 3.0 : 1.0;
      Eigen::Vector3d slip = Gaussian3(random, kSlip_m * force);
      slip.z() *= 0.3;
      way += slip;
      rotation.z() += kSlip_rad * force * random.Gaussian();
      translation_variance += std::pow(2.0 * kSlip_m, 2);
      rotation_variance += std::pow(2.0 * kSlip_rad, 2);
    }
    T_odom_body.translation() += T_odom_body.linear() * way;
    T_odom_body.linear() =
        (Eigen::Quaterniond(T_odom_body.linear()) * Small(rotation)).normalized().toRotationMatrix();
    T_world_body = now;
    PriorRecord record;
    record.t = TimeOf(t_start, i, rate_hz);
    record.T_odom_body = T_odom_body;
    record.rotation_sigma_rad = Eigen::Vector3d(0.3, 0.3, 1.0) * std::sqrt(rotation_variance);
    record.translation_sigma_m = Eigen::Vector3d(1.0, 1.0, 0.5) * std::sqrt(translation_variance);
    records.push_back(record);
  }
  return records;
}

}  // namespace terrace::synthetic
