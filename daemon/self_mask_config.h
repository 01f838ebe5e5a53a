// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

/// What the robot sees of itself, beside robot.self_mask_png. YAML section: `robot`.
struct SelfMaskConfig {
  /// Whether self_mask_png is drawn over the rectified left image (terrace draw shows it) or over the raw
  /// one.
  std::string self_mask_pixels = "rectified";
  /// Parts of the robot that do not move against its body, as boxes along the body's axes: x, y, z of one
  /// corner, then of the opposite one; six numbers a box. What the left camera sees of them is masked.
  std::vector<double> self_boxes_m;
  /// Likewise capsules, as legs and rods are: x, y, z of one end, of the other, radius; seven numbers a
  /// capsule.
  std::vector<double> self_capsules_m;

  bool has_parts() const { return !self_boxes_m.empty() || !self_capsules_m.empty(); }
  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
