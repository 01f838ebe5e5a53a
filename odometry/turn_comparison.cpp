// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/turn_comparison.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

constexpr double kOver_s = 2.0;
/// Of one frame: what turns less says more of the noise of both than of the IMU.
constexpr double kLeastTurn_rad = 0.008;
/// One image that was misread must not outweigh the others.
constexpr double kMostTurn_rad = 0.05;
constexpr int kEnoughTurns = 12;  // frames
/// Of the square of the turns. A sensor that is a tenth of a second late in a gait is beyond, one that is
/// right stays under a tenth of it.
constexpr double kMostApart = 0.3;

Eigen::Vector3d Limited(const Eigen::Vector3d& v, double most) {
  const double norm = v.norm();
  return norm > most ? Eigen::Vector3d(v * (most / norm)) : v;
}

}  // namespace

void TurnComparison::Hear(const Eigen::Vector3d& by_imu_rad, const Eigen::Vector3d& by_images_rad,
                          double dt_s) {
  if (std::max(by_imu_rad.norm(), by_images_rad.norm()) < kLeastTurn_rad) return;
  const double keep = std::exp(-std::max(dt_s, 0.0) / kOver_s);
  const Eigen::Vector3d images = Limited(by_images_rad, kMostTurn_rad);
  images_images_ = keep * images_images_ + images.squaredNorm();
  imu_images_ = keep * imu_images_ + by_imu_rad.dot(images);
  apart_apart_ = keep * apart_apart_ + Limited(by_imu_rad - by_images_rad, kMostTurn_rad).squaredNorm();
  ++num_turns_;
}

std::optional<std::string> TurnComparison::Problem() const {
  if (num_turns_ < kEnoughTurns || apart_apart_ < kMostApart * images_images_) return std::nullopt;
  const std::string otherwise = "the IMU turns otherwise than the images: ";
  // What an image that stands still says of a unit is nothing.
  const double factor = imu_images_ / std::max(images_images_, 1e-9);
  if (factor > 25.0 && factor < 120.0)
    return otherwise + "its gyroscope seems to measure in degrees per second";
  if (factor > -1.5 && factor < -0.6) return otherwise + "the sign of its gyroscope seems to be turned";
  return otherwise + "check T_BS of the IMU, its axes, its units, its bias and its clock";
}

}  // namespace terrace
