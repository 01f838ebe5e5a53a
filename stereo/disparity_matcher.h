// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stereo/disparity_image.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Settings of the disparity matcher. YAML section: `stereo`.
struct DisparityConfig {
  /// Search range; the nearest visible depth is focal_px * baseline_m / this. A multiple of 16, at most 256.
  int max_disparity_px = 128;
  /// Left-right agreement a pixel needs to be kept.
  double max_left_right_error_px = 1.0;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Dense stereo. Same input, same output, for any number of threads.
class DisparityMatcher {
 public:
  /// Throws std::invalid_argument with every problem of the settings.
  explicit DisparityMatcher(const DisparityConfig& config);
  ~DisparityMatcher();

  DisparityImage Match(const StereoFrame& frame);

 private:
  class Impl;  // holds the buffers, so that a frame allocates nothing but its result
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
