// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/geometry.h"
#include "core/place_view.h"
#include "core/time.h"
#include "odometry/image_pyramid.h"
#include "odometry/window.h"

namespace terrace {

/// What is kept of a keyframe: enough to recognise the place and to close a loop.
struct ArchivedKeyframe {
  KeyframeId id = 0;
  FrameId frame_id = 0;
  Timestamp t_capture;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< against the first pose
  std::vector<PlaceCorner> points;
};

/// Keyframes of the whole walk, thinned so that memory stays bounded.
class KeyframeArchive {
 public:
  KeyframeArchive(const StereoCamera& camera, int max_keyframes);

  /// Keeps the landmarks that the keyframe hosts and that have proved to stand still. Replaces what was kept
  /// of the same keyframe.
  void Add(const Keyframe& keyframe, const std::vector<Landmark>& landmarks, const Matrix6d& covariance);

  /// A pose found by recognising a keyframe.
  struct Recognition {
    Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
    Matrix6d covariance = Matrix6d::Zero();
    int num_inliers = 0;
  };
  /// Compares new features with the keyframes nearest to where the camera should be.
  /// @param landmarks  features of the frame with their disparities
  /// @param attempt  0: with the nearest; then with the next ones, and so on
  std::optional<Recognition> Recognize(const ImagePyramid& left, const std::vector<Landmark>& landmarks,
                                       const Eigen::Isometry3d& expected_T_world_left, int attempt,
                                       std::uint32_t seed) const;

  const std::vector<ArchivedKeyframe>& keyframes() const { return keyframes_; }

 private:
  StereoCamera camera_;
  std::size_t max_keyframes_;
  std::vector<ArchivedKeyframe> keyframes_;  ///< oldest first
};

}  // namespace terrace
