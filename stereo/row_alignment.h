// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// The same point in both images of a rectified pair, sub-pixel, found without trusting that rows are
/// aligned.
struct RowMatch {
  Eigen::Vector2d left_px;
  Eigen::Vector2d right_px;
};

/// How far to look for it.
struct RowMatchConfig {
  int max_features = 300;
  int max_disparity_px = 128;
  int max_row_error_px = 14;
};

/// Corners of the left image found in the right one. Those that are found twice, or badly, are left out.
std::vector<RowMatch> MatchAcrossRows(const StereoFrame& frame, const RowMatchConfig& config = {});

/// What is wrong between the cameras, as far as rows tell. Standard deviations are those of the fit and of
/// what all points have in common.
struct RowAlignment {
  static constexpr int kFewestMatches = 20;

  int num_matches = 0;
  double median_px = 0.0;     ///< of |row in the right image - row in the left one|
  double p95_px = 0.0;        ///< 95 % are below this
  double left_over_px = 0.0;  ///< median after what follows has been corrected
  double row_shift_px = 0.0;  ///< the right image is this much lower, in its middle
  double row_shift_sigma_px = 0.0;
  double roll_rad = 0.0;  ///< the right image is turned clockwise by this
  double roll_sigma_rad = 0.0;
  double focal_ratio = 1.0;  ///< the right image is this much larger
  double focal_ratio_sigma = 0.0;
};

/// Fits a rotation, a shift and a scale of the right camera to the rows, robustly. Below kFewestMatches:
/// nothing but their number.
RowAlignment EstimateRowAlignment(const std::vector<RowMatch>& matches, const StereoCamera& camera);

}  // namespace terrace
