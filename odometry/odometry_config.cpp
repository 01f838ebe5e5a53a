// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/odometry_config.h"

namespace terrace {

std::vector<std::string> OdometryConfig::Problems() const {
  std::vector<std::string> problems;
  const auto Require = [&problems](bool holds, const std::string& sentence) {
    if (!holds) problems.push_back(sentence);
  };
  Require(num_cells >= 40 && num_cells <= 2000, "num_cells must lie in 40..2000");
  Require(max_disparity_px >= 16 && max_disparity_px <= 512, "max_disparity_px must lie in 16..512");
  Require(window_keyframes >= 3 && window_keyframes <= 30, "window_keyframes must lie in 3..30");
  Require(keyframe_parallax > 0.0 && keyframe_parallax < 1.0, "keyframe_parallax must lie between 0 and 1");
  Require(keyframe_min_coverage > 0.0 && keyframe_min_coverage < 1.0,
          "keyframe_min_coverage must lie between 0 and 1");
  Require(min_inliers >= 6, "min_inliers must be at least 6");
  Require(archived_keyframes >= 2 && archived_keyframes <= 10000, "archived_keyframes must lie in 2..10000");
  Require(optimizer_iterations >= 0 && optimizer_iterations <= 50, "optimizer_iterations must lie in 0..50");
  Require(max_bridging_s > 0.0, "max_bridging_s must be positive");
  Require(max_speed_mps > 0.0, "max_speed_mps must be positive");
  Require(max_turn_rate_dps > 0.0, "max_turn_rate_dps must be positive");
  Require(max_vertical_disparity_px > 0.0, "max_vertical_disparity_px must be positive");
  return problems;
}

}  // namespace terrace
