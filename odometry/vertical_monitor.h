// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "odometry/landmark_tracker.h"
#include "odometry/pose_solver.h"

namespace terrace {

/// Follows how much lower the right image lies than the calibration says.
class VerticalMonitor {
 public:
  explicit VerticalMonitor(double max_vertical_disparity_px) : max_px_(max_vertical_disparity_px) {}

  /// v in the right image less v in the left one [px], a running estimate.
  double vertical_px() const { return vertical_px_; }
  /// @return what the user should be told, once
  std::optional<std::string> Update(const std::vector<Match>& matches, const PoseSolution& solution);

 private:
  double max_px_;
  double vertical_px_ = 0.0;
  bool warned_ = false;
};

}  // namespace terrace
