// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "datasets/sequence.h"
#include "stereo/rectifier.h"
#include "stereo/row_alignment.h"
#include "tools/pair_delay.h"

namespace terrace {

/// What the images of a recording say about the calibration that they were rectified with.
struct CalibrationCheck {
  RowAlignment rows;              ///< where a delay is told, without what it does to moving rows
  RowAlignment rows_as_they_are;  ///< with it
  PairDelay delay;
  std::vector<RowMatch> matches;  ///< all that were found
  cv::Mat1b last_left;            ///< rectified; of the last frame that was looked at
};

/// Looks at some twenty frames, spread over the recording, each between four neighbours that tell the motion.
CalibrationCheck CheckCalibration(const Rectifier& rectifier, Sequence* sequence);

}  // namespace terrace
