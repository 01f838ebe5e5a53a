// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/merging_config.h"

namespace terrace {

std::vector<std::string> MergingConfig::Problems() const {
  std::vector<std::string> problems;
  const auto positive = [&](double value, const char* name) {
    if (!(value > 0.0)) problems.push_back(std::string(name) + " must be above 0");
  };
  positive(max_offset_m, "max_offset_m");
  if (!(max_angle_deg > 0.0 && max_angle_deg < 45.0))
    problems.push_back("max_angle_deg must be between 0 and 45");
  positive(max_gap_m, "max_gap_m");
  if (!(min_width_m >= 0.0)) problems.push_back("min_width_m must not be negative");
  positive(min_area_m2, "min_area_m2");
  positive(outline_resolution_m, "outline_resolution_m");
  positive(simplify_m, "simplify_m");
  if (max_vertices < 16 || max_vertices > 5000) {
    problems.push_back("max_vertices = " + std::to_string(max_vertices) + " must lie between 16 and 5000");
  }
  positive(min_change_m, "min_change_m");
  if (!(max_extent_m >= 2.0)) problems.push_back("max_extent_m must be at least 2");
  return problems;
}

}  // namespace terrace
