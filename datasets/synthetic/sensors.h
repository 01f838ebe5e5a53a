// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "datasets/synthetic/renderer.h"
#include "datasets/synthetic/trajectory.h"

namespace terrace::synthetic {

/// Turns light into grey values as a camera does: vignetting, gain, shot and read noise, sRGB curve.
class ImageSensor {
 public:
  explicit ImageSensor(const Photometry& photometry);
  /// @param gain  of this camera at this exposure
  GrayImage Expose(const Radiance& light, double gain, std::uint32_t seed) const;
  /// Mean of the light as it arrives behind the lens.
  double MeanOf(const Radiance& light) const;

 private:
  double VignetteAt(int x, int y, int width, int height) const;

  Photometry photometry_;
  std::vector<std::uint8_t> curve_;  ///< linear 0..1 to grey
};

/// Keeps the mean brightness of the left image near the target.
class AutoExposure {
 public:
  AutoExposure(double target, double speed_hz, double rate_hz);
  /// The gain for an image with this mean, learnt from those before it; the first is exposed right.
  double GainFor(double mean);

 private:
  double target_;
  double speed_;  ///< share of the error made good in a frame
  double gain_ = 0.0;
  double next_gain_ = 0.0;
};

/// What an IMU of the body would measure without error.
ImuSample PerfectImu(const Trajectory& trajectory, double t_s, Timestamp t);

struct ImuRecord {
  ImuSample sample;
  Eigen::Vector3d gyro_bias;
  Eigen::Vector3d accel_bias;
};
/// Measurements at `rate_hz` with white noise and biases that walk.
std::vector<ImuRecord> SimulateImu(const Trajectory& trajectory, const ImuNoise& noise, double rate_hz,
                                   Timestamp t_start, std::uint32_t seed);

/// What the robot believes about itself.
struct PriorRecord {
  Timestamp t;
  Eigen::Isometry3d T_odom_body = Eigen::Isometry3d::Identity();
  Eigen::Vector3d rotation_sigma_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_sigma_m = Eigen::Vector3d::Zero();
};
/// An attitude filter: roll and pitch wander about the truth by half a degree, yaw drifts away.
std::vector<PriorRecord> SimulateAttitude(const Trajectory& trajectory, double rate_hz, Timestamp t_start,
                                          std::uint32_t seed);
/// Leg odometry from the first pose on: 3 % too far, and feet slip when they strike. Its sigmas grow; the
/// difference of the squares of two samples is the variance of the motion between them.
std::vector<PriorRecord> SimulateLegs(const Trajectory& trajectory, double rate_hz, Timestamp t_start,
                                      std::uint32_t seed);

}  // namespace terrace::synthetic
