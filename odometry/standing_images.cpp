// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/standing_images.h"

#include <utility>

#include "stereo/image_fingerprint.h"

namespace terrace {

void StandingImages::See(const StereoFrame& frame) {
  const std::uint64_t left = ImageFingerprint(frame.left), right = ImageFingerprint(frame.right);
  left_ = std::exchange(left_fingerprint_, left) == left;
  right_ = std::exchange(right_fingerprint_, right) == right;
  num_both_ = left_ && right_ ? num_both_ + 1 : 0;
  num_right_alone_ = right_ && !left_ ? num_right_alone_ + 1 : 0;
}

}  // namespace terrace
