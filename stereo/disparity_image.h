// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>

#include <opencv2/core/mat.hpp>

#include "core/time.h"
#include "stereo/row_offsets.h"

namespace terrace {

/// Disparity of every pixel of the rectified left image.
struct DisparityImage {
  FrameId frame_id = 0;
  Timestamp t_capture;
  /// CV_32FC1 [px]; a point at u in the left image is at u - disparity in the right one. NaN = unknown.
  cv::Mat1f disparity_px;
  /// CV_32FC1 [px], standard deviation of what differs from pixel to pixel; NaN exactly where the disparity
  /// is.
  cv::Mat1f sigma_px;
  /// Standard deviation of what a rig that is not calibrated exactly adds, which neighbours share: it moves
  /// and bends surfaces, and blurs none.
  float misalignment_px = 0.0f;
  /// By how many rows the right image was off before it was matched, from the middle of what was matched.
  RowOffsets row_offsets;
  /// Of the pixels that were matched, those where nothing that was searched fits: unknown in the disparity.
  /// What only the left camera sees counts among them.
  float no_match_share = 0.0f;
  /// Of the same, those whose best disparity is the last one of the search, or beyond what the settings
  /// allow: what they show is probably nearer still.
  float limit_share = 0.0f;
  /// Greatest disparity that was searched for; what is nearer is unknown.
  float range_px = std::numeric_limits<float>::infinity();

  /// Standard deviation of all that a disparity may be wrong by; NaN where it is unknown.
  float TotalSigma(int pixel) const { return std::hypot(sigma_px(pixel), misalignment_px); }
};

}  // namespace terrace
