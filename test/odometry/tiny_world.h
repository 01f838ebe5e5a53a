// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/camera.h"
#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "odometry/imu_preintegration.h"
#include "odometry/odometry_config.h"
#include "odometry/rotation.h"
#include "stereo/stereo_frame.h"

namespace terrace::test {

inline const StereoCamera kCamera{320, 240, 200.0, 200.0, 159.5, 119.5, 0.12};
constexpr int kTextureSize = 512;

/// Stands upright in the way: all of its height, or every second strip of it.
struct Panel {
  double z_m = 0.0;
  double right_m = 0.0;                                     ///< edge
  double slat_m = std::numeric_limits<double>::infinity();  ///< height of its slats and of the gaps between
};

/// A floor 0.5 m below the camera and a wall 3 m ahead, both with smooth noise on them.
class TinyWorld {
 public:
  /// @param period_px  after which the texture repeats itself, a power of two
  explicit TinyWorld(int period_px = kTextureSize, std::uint32_t seed = 1) : period_px_(period_px) {
    std::mt19937 random(seed);
    cv::Mat1f noise(kTextureSize, kTextureSize);
    for (float& value : noise) value = static_cast<float>(random() % 1000) / 1000.0f;
    cv::Mat1f fine, coarse;
    cv::GaussianBlur(noise, fine, {}, 1.5, 1.5, cv::BORDER_REFLECT);
    cv::GaussianBlur(noise, coarse, {}, 8.0, 8.0, cv::BORDER_REFLECT);
    texture_ = 128.0f + 500.0f * (fine - 0.5f) + 2500.0f * (coarse - 0.5f);
  }

  void PutUp(const Panel& panel) { panel_ = panel; }

  cv::Mat1b View(const Eigen::Isometry3d& T_start_camera, double gain = 1.0) const {
    cv::Mat1b image(kCamera.height, kCamera.width);
    const Eigen::Vector3d eye = T_start_camera.translation();
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector3d ray =
            T_start_camera.linear() *
            Eigen::Vector3d((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy, 1.0);
        const double to_floor = ray.y() > 1e-6 ? (0.5 - eye.y()) / ray.y() : 1e9;
        const double to_wall = ray.z() > 1e-6 ? (3.0 - eye.z()) / ray.z() : 1e9;
        const Eigen::Vector3d p = eye + std::min(to_floor, to_wall) * ray;
        const double grey =
            to_floor < to_wall ? Grey(p.x() * 150.0, p.z() * 150.0) : Grey(p.x() * 60.0 + 99.0, p.y() * 60.0);
        if (const auto on_panel = HitPanel(eye, ray, std::min(to_floor, to_wall))) {
          image(v, u) = cv::saturate_cast<std::uint8_t>(
              gain * Grey(on_panel->x() * 150.0 + 300.0, on_panel->y() * 150.0));
          continue;
        }
        image(v, u) = cv::saturate_cast<std::uint8_t>(gain * grey);
      }
    }
    return image;
  }

  StereoFrame Frame(FrameId id, const Eigen::Isometry3d& T_start_left, double gain = 1.0) const {
    StereoFrame frame;
    frame.frame_id = id;
    frame.t_capture = Timestamp{1'000'000'000 + id * 66'000'000};
    frame.left = View(T_start_left, gain);
    frame.right = View(T_start_left * Eigen::Translation3d(kCamera.baseline_m, 0, 0), gain);
    return frame;
  }

 private:
  std::optional<Eigen::Vector3d> HitPanel(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray,
                                          double to_next) const {
    if (!panel_ || ray.z() < 1e-6) return std::nullopt;
    const double to_panel = (panel_->z_m - eye.z()) / ray.z();
    const Eigen::Vector3d p = eye + to_panel * ray;
    const bool hit =
        to_panel > 0 && to_panel < to_next && p.x() < panel_->right_m &&
        (std::isinf(panel_->slat_m) || std::fmod(p.y() + 100.0, 2 * panel_->slat_m) < panel_->slat_m);
    return hit ? std::optional(p) : std::nullopt;
  }
  double Grey(double x, double y) const {
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    const int ix = static_cast<int>(std::floor(x)) & (period_px_ - 1),
              iy = static_cast<int>(std::floor(y)) & (period_px_ - 1);
    const int jx = (ix + 1) & (period_px_ - 1), jy = (iy + 1) & (period_px_ - 1);
    return (1 - fy) * ((1 - fx) * texture_(iy, ix) + fx * texture_(iy, jx)) +
           fy * ((1 - fx) * texture_(jy, ix) + fx * texture_(jy, jx));
  }
  int period_px_;
  cv::Mat1f texture_;
  std::optional<Panel> panel_;
};

inline const TinyWorld& World() {
  static const TinyWorld world;
  return world;
}

/// A bouncing walk: 2.5 cm a frame, with turns.
inline Eigen::Isometry3d Walk(double frame) {
  Vector6d step;
  step << 0.02 * std::sin(0.9 * frame), 0.03 * std::sin(0.3 * frame), 0.01 * std::sin(0.5 * frame),
      0.01 * std::sin(0.4 * frame), 0.015 * std::sin(1.1 * frame), 0.025 * frame;
  return Perturb(Eigen::Isometry3d::Identity(), step);
}

inline Eigen::Isometry3d FromStart(const PoseEstimate& first, const PoseEstimate& pose) {
  return first.T_world_left.inverse() * pose.T_world_left;
}

constexpr double kFrame_s = 0.066;
constexpr std::int64_t kFrame_ns = 66'000'000;

/// What an IMU in the left camera measures on the walk between a frame and the one before; y is down.
inline SensorSamples ImuUpTo(int frame) {
  constexpr int kSamples = 13;
  SensorSamples samples;
  for (int k = 1; k <= kSamples; ++k) {
    const double at = frame - 1 + static_cast<double>(k) / kSamples;
    constexpr double kStep = 0.01;  // frames
    const Eigen::Isometry3d before = Walk(at - kStep), now = Walk(at), after = Walk(at + kStep);
    ImuSample sample;
    sample.t = Timestamp{1'000'000'000 + std::llround(at * static_cast<double>(kFrame_ns))};
    sample.gyro = LogRotation(before.linear().transpose() * after.linear()) / (2 * kStep * kFrame_s);
    const Eigen::Vector3d acceleration =
        (after.translation() - 2 * now.translation() + before.translation()) / std::pow(kStep * kFrame_s, 2);
    sample.accel = now.linear().transpose() * (acceleration - kGravityMagnitude * Eigen::Vector3d::UnitY());
    samples.imu.push_back(sample);
  }
  return samples;
}

/// An IMU that sits in the left camera, and its noise.
inline Mounting WithImu() {
  Mounting mounting;
  mounting.T_left_imu = Eigen::Isometry3d::Identity();
  mounting.imu_noise = {1e-3, 1e-5, 1e-2, 1e-4};
  return mounting;
}

/// The same samples with the noise that WithImu() claims.
inline SensorSamples WithNoise(SensorSamples samples, std::mt19937& random) {
  const double root_rate = std::sqrt(static_cast<double>(samples.imu.size()) / kFrame_s);
  std::normal_distribution<double> normal;
  for (ImuSample& sample : samples.imu) {
    for (int axis = 0; axis < 3; ++axis) {
      sample.gyro[axis] += WithImu().imu_noise.gyro_density * root_rate * normal(random);
      sample.accel[axis] += WithImu().imu_noise.accel_density * root_rate * normal(random);
    }
  }
  return samples;
}

/// Body x forward, y left, z up, in the camera's place.
inline Mounting WithBody() {
  Mounting mounting;
  mounting.T_body_left = Eigen::Isometry3d::Identity();
  mounting.T_body_left->linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return mounting;
}

/// What body attitude or legs say at a frame: true, in an odometry frame of their own that was turned at
/// will.
inline BodyPrior PriorAt(int frame, PriorKind kind) {
  const Eigen::Isometry3d T_body_left = *WithBody().T_body_left;
  BodyPrior prior;
  prior.t = Timestamp{1'000'000'000 + frame * kFrame_ns};
  prior.kind = kind;
  prior.T_odom_body = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(3, -2, 1) *
                      T_body_left * Walk(frame) * T_body_left.inverse();
  prior.covariance.diagonal().setConstant(1e-6);
  return prior;
}

inline StereoFrame Black(StereoFrame frame) {
  frame.left.setTo(2);
  frame.right.setTo(2);
  return frame;
}

inline double ErrorMm(const PoseEstimate& first, const PoseEstimate& pose, int frame) {
  return 1e3 *
         (FromStart(first, pose).translation() - (Walk(0).inverse() * Walk(frame)).translation()).norm();
}

}  // namespace terrace::test
