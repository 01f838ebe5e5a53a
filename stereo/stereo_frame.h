// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <opencv2/core/mat.hpp>

#include "core/time.h"

namespace terrace {

/// A rectified pair: rows aligned, both CV_8UC1 of the size of the StereoCamera. Nobody edits the pixels.
struct StereoFrame {
  FrameId frame_id = 0;
  Timestamp t_capture;  ///< middle of the exposure
  cv::Mat1b left;
  cv::Mat1b right;
};
using StereoFramePtr = std::shared_ptr<const StereoFrame>;

}  // namespace terrace
