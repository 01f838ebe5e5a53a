// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"

namespace terrace::test {

/// A rig of 160x120 pixels on a body, small enough for tests under sanitizers.
inline StereoCalibration TinyCalibration() {
  StereoCalibration c;
  c.name = "tiny";
  c.width = 160;
  c.height = 120;
  c.left = c.right = {.fx = 110, .fy = 110, .cx = 79.5, .cy = 59.5, .distortion = {}};
  c.T_rawright_rawleft.translation().x() = -0.12;
  // Looking forward, 30 deg down, 0.1 m in front of and above the body.
  Eigen::Isometry3d T_body_left = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d level;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T_body_left.linear() = Eigen::AngleAxisd(0.52, Eigen::Vector3d::UnitY()) * level;
  T_body_left.translation() = Eigen::Vector3d(0.1, 0.0, 0.1);
  c.T_body_rawleft = T_body_left;
  return c;
}

/// A floor and a wall 2.5 m ahead with a texture that is smooth at the scale of these pixels.
inline double TinyTexture(double a, double b) {
  double value = 0.0;
  double amplitude = 40.0;
  double frequency = 4.0;
  for (int octave = 0; octave < 4; ++octave) {
    value +=
        amplitude * std::sin(frequency * a + 1.7 * octave) * std::cos(frequency * 1.1 * b + 0.6 * octave + a);
    amplitude *= 0.7;
    frequency *= 1.9;
  }
  return 128.0 + value;
}

inline GrayImage TinyView(const StereoCalibration& calibration, const Eigen::Isometry3d& T_world_camera) {
  GrayImage image{calibration.width, calibration.height, {}};
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const Eigen::Vector3d ray =
          T_world_camera.linear() * Eigen::Vector3d((u - calibration.left.cx) / calibration.left.fx,
                                                    (v - calibration.left.cy) / calibration.left.fy, 1.0);
      const Eigen::Vector3d& eye = T_world_camera.translation();
      const double to_floor = ray.z() < -1e-6 ? -eye.z() / ray.z() : 1e9;
      const double to_wall = ray.x() > 1e-6 ? (2.5 - eye.x()) / ray.x() : 1e9;
      const Eigen::Vector3d p = eye + std::min(to_floor, to_wall) * ray;
      const double value = to_floor < to_wall ? TinyTexture(p.x(), p.y()) : TinyTexture(p.y() + 5.0, p.z());
      image.data.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
    }
  }
  return image;
}

/// Frames of a body that walks forward at 0.36 m above the floor, 10 a second.
inline std::vector<SensorFrame> TinySequence(int num_frames) {
  const StereoCalibration calibration = TinyCalibration();
  std::vector<SensorFrame> frames;
  for (int i = 0; i < num_frames; ++i) {
    Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
    T_world_body.translation() = Eigen::Vector3d(0.03 * i, 0.01 * std::sin(i), 0.36);
    const Eigen::Isometry3d T_world_left = T_world_body * *calibration.T_body_rawleft;
    SensorFrame frame;
    frame.frame_id = i;
    frame.pair.t_capture = Timestamp{1'600'000'000'000'000'000 + i * 100'000'000LL};
    frame.pair.left = TinyView(calibration, T_world_left);
    frame.pair.right = TinyView(calibration, T_world_left * calibration.T_rawright_rawleft.inverse());
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace terrace::test
