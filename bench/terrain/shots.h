// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "core/pose_estimate.h"
#include "daemon/pipeline.h"
#include "datasets/sequence.h"
#include "stereo/disparity_image.h"

namespace terrace {

/// One frame, matched and tracked: what a map is made of, to be shown to it as often as wanted.
struct Shot {
  std::shared_ptr<const DisparityImage> disparity;
  PoseEstimate pose;
  Gravity gravity;
};

/// The first frames of a sequence that may be mapped, at most so many.
std::vector<Shot> ShootFrames(Sequence* sequence, Pipeline* pipeline, int num_frames);

std::vector<Shot> OneIn(int stride, const std::vector<Shot>& shots);

}  // namespace terrace
