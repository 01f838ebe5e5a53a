// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/vertical_monitor.h"

#include <algorithm>
#include <cmath>

namespace terrace {

std::optional<std::string> VerticalMonitor::Update(const std::vector<Match>& matches,
                                                   const PoseSolution& solution) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (solution.inlier[i] && matches[i].measurement.has_disparity) errors.push_back(matches[i].vertical_px);
  constexpr std::size_t kEnough = 20;
  if (errors.size() < kEnough) return std::nullopt;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  constexpr double kRate = 0.03;
  vertical_px_ += kRate * (errors[errors.size() / 2] - vertical_px_);
  if (std::abs(vertical_px_) <= max_px_ || warned_) return std::nullopt;
  warned_ = true;
  return "the right image lies " + std::to_string(vertical_px_) +
         " px lower than the calibration says: calibrate the cameras again";
}

}  // namespace terrace
