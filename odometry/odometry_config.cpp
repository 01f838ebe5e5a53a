// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/odometry_config.h"

#include "core/field_problems.h"

namespace terrace {

std::vector<std::string> OdometryConfig::Problems() const {
  FieldProblems problems;
  problems.RequireWithin("num_cells", num_cells, 40, 2000);
  problems.RequireWithin("max_disparity_px", max_disparity_px, 16, 512);
  problems.RequireWithin("window_keyframes", window_keyframes, 3, 30);
  problems.RequireInside("keyframe_parallax", keyframe_parallax, 0.0, 1.0);
  problems.RequireInside("keyframe_min_coverage", keyframe_min_coverage, 0.0, 1.0);
  problems.RequireAtLeast("min_inliers", min_inliers, 6);
  problems.RequireWithin("archived_keyframes", archived_keyframes, 2, 10000);
  problems.RequireWithin("optimizer_iterations", optimizer_iterations, 0, 50);
  problems.RequireAbove("max_bridging_s", max_bridging_s, 0.0);
  problems.RequireAbove("max_speed_mps", max_speed_mps, 0.0);
  problems.RequireAbove("max_turn_rate_dps", max_turn_rate_dps, 0.0);
  problems.RequireAbove("max_vertical_disparity_px", max_vertical_disparity_px, 0.0);
  return problems.Take();
}

}  // namespace terrace
