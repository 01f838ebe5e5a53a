// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  /// CV_32FC1 [px], standard deviation; NaN exactly where the disparity is.
  cv::Mat1f sigma_px;
  /// By how many rows the right image was off before it was matched, from the middle of what was matched.
  RowOffsets row_offsets;
};

}  // namespace terrace
