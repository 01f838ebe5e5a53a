// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "odometry/mounting.h"

namespace terrace {

/// Settings of the odometry. YAML section: `odometry`.
struct OdometryConfig {
  /// Use the IMU when the sequence has one.
  bool use_imu = true;
  /// Use body attitude and leg odometry when they arrive.
  bool use_priors = true;
  /// Cells of the grid over the image; each keyframe holds at most one new feature a cell.
  int num_cells = 260;
  /// Nearest point of which a new feature is made: focal_px * baseline_m / this.
  int max_disparity_px = 192;
  /// Keyframes that are refined together.
  int window_keyframes = 8;
  /// Keyframes kept with descriptors of their features, to find back to; older ones are thinned out.
  int archived_keyframes = 200;
  /// Steps of the refinement at each keyframe, at most.
  int optimizer_iterations = 3;
  /// A new keyframe when features have moved this far by translation, as a share of the focal length.
  double keyframe_parallax = 0.06;
  /// A new keyframe when fewer than this share of the cells still holds a feature that was found.
  double keyframe_min_coverage = 0.45;
  /// Below this many points that agree, the images do not count as tracked; with an IMU, half as many will
  /// do.
  int min_inliers = 15;
  /// Bridging longer than this without an image that counts is being lost. Then either a place is recognised,
  /// or a new world begins.
  double max_bridging_s = 2.0;
  /// Faster than this the camera never moves: what says so is not believed.
  double max_speed_mps = 25.0;
  /// Nor does it turn faster than this.
  double max_turn_rate_dps = 1500.0;
  /// Vertical disparity of the pair beyond which a warning names the calibration.
  double max_vertical_disparity_px = 0.5;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
