// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/time.h"
#include "odometry/image_pyramid.h"
#include "odometry/imu_preintegration.h"

namespace terrace {

using KeyframeId = std::int64_t;

/// A feature of one stereo frame: where it is in the left image, and its disparity.
struct StereoMeasurement {
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();  ///< u, v, disparity [px]
  Eigen::Matrix2d covariance_uv = Eigen::Matrix2d::Identity();
  double sigma_d = 1.0;
  bool has_disparity = false;
};

/// A landmark as one keyframe sees it.
struct Observation {
  KeyframeId keyframe = 0;
  StereoMeasurement measurement;
};

/// A point of the world on a small plane. It lies on the ray of one pixel of its host keyframe, whose texture
/// it carries, so only its depth is unknown.
struct Landmark {
  std::int64_t id = 0;
  KeyframeId host = 0;
  Eigen::Vector2d pixel_host = Eigen::Vector2d::Zero();
  Eigen::Vector3d ray_host = Eigen::Vector3d::UnitZ();  ///< z = 1
  double inverse_depth = 0.0;                           ///< 1/m, along z of the host
  double inverse_depth_sigma = 0.0;
  /// Change of the disparity per pixel along u and v in the host: the slant of the plane.
  Eigen::Vector2d disparity_gradient = Eigen::Vector2d::Zero();
  double disparity_host_px = 0.0;  ///< as measured in the host
  double disparity_host_sigma_px = 1.0;
  std::vector<Observation> observations;  ///< in later keyframes
  int num_failures = 0;                   ///< in a row: found where it cannot be
  int num_tracked = 0;                    ///< frames that agreed with it
  int num_missed = 0;                     ///< frames in which it was looked for and did not agree
  bool missed_last = false;               ///< it did not agree when it was last looked for

  /// How far it is believed to stand still, 0..1: what moves never grows old.
  double trust() const;
};

/// What one keyframe is known to be.
struct KeyframeState {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity_world =
      Eigen::Vector3d::Zero();  ///< of the IMU; like the biases, only with an IMU
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
};

struct Keyframe : KeyframeState {
  KeyframeId id = 0;
  FrameId frame_id = 0;
  Timestamp t_capture;
  ImagePyramid left;
  std::optional<ImuPreintegration> imu;  ///< from the keyframe before
};

/// The keyframes that are still being refined, oldest first, and the landmarks they host.
struct Window {
  std::deque<Keyframe> keyframes;
  std::vector<Landmark> landmarks;

  const Keyframe& at(KeyframeId id) const {
    return keyframes[static_cast<std::size_t>(id - keyframes.front().id)];
  }
};

/// A landmark seen from a frame at T_world_left. All in terms of q = inverse_depth * p_left, which stays
/// finite for points at infinity.
struct Projection {
  Eigen::Vector3d q = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d uvd = Eigen::Vector3d::Zero();
  Eigen::Vector3d uvd_by_inverse_depth = Eigen::Vector3d::Zero();
  /// d(pixel here) / d(pixel in the host), over the landmark's plane.
  Eigen::Matrix2d A_here_host = Eigen::Matrix2d::Identity();
  /// Slant of the plane as seen from here.
  Eigen::Vector2d disparity_gradient = Eigen::Vector2d::Zero();
};

/// @return false when the landmark lies behind the camera or is seen edge-on.
bool Project(const Landmark& landmark, const Eigen::Isometry3d& T_left_host, const StereoCamera& camera,
             Projection& projection);

}  // namespace terrace
