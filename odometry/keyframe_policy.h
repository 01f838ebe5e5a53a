// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/camera.h"
#include "odometry/feature_finder.h"
#include "odometry/image_pyramid.h"
#include "odometry/odometry_config.h"
#include "odometry/pose_finder.h"
#include "odometry/window.h"

namespace terrace {

/// Decides which tracked frames become keyframes: seldom enough that errors do not add up, often enough that
/// there is always something to see.
class KeyframePolicy {
 public:
  KeyframePolicy(const OdometryConfig& config, const StereoCamera& camera, const FeatureGrid& grid)
      : config_(config), camera_(camera), grid_(grid) {}

  /// @param age_s  of the newest keyframe, at the frame before
  bool Wants(const Window& window, const ImagePyramid& left, const PoseFinder::Found& found, bool with_imu,
             double age_s);
  /// A keyframe was made.
  /// @param rests  whether the camera had hardly moved since the one before
  /// @param covered_cells  with a landmark just after it
  void NoteMade(bool rests, double covered_cells);

 private:
  bool Needs(const Window& window, const PoseFinder::Found& found, bool with_imu, double age_s) const;
  bool WaitForCertainty(const PoseFinder::Found& found);
  bool WaitForSharperImage(const ImagePyramid& left);

  OdometryConfig config_;
  StereoCamera camera_;
  FeatureGrid grid_;
  double usual_sharpness_ = 0.0;  ///< of frames that would become keyframes
  int num_waited_ = 0;            ///< for a sharper one, frames in a row
  int num_doubtful_ = 0;          ///< poses that would become keyframes, in a row
  double covered_cells_ = 1.0;    ///< cells with a landmark just after the newest keyframe
  int keyframes_at_rest_ = 0;     ///< in a row
};

}  // namespace terrace
