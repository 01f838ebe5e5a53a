// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "stereo/stereo_frame.h"

namespace terrace {

/// Notices images that are bit by bit those of the frame before: a frozen camera, or a driver that gives out
/// old memory. What such an image shows is a moment that has been seen already.
class StandingImages {
 public:
  void See(const StereoFrame& frame);

  /// The left camera has given the same image again while the right one went on.
  bool left_alone() const { return left_ && !right_; }
  /// The right one has, so often in a row, while the left one went on.
  int num_right_alone() const { return num_right_alone_; }
  /// Both have: frozen, or a recording of one pair that is repeated.
  bool both() const { return num_both_ > 0; }
  /// So often in a row.
  int num_both() const { return num_both_; }

 private:
  std::uint64_t left_fingerprint_ = 0, right_fingerprint_ = 0;  // of the frame before; 0: there was none
  bool left_ = false, right_ = false;
  int num_both_ = 0, num_right_alone_ = 0;
};

}  // namespace terrace
