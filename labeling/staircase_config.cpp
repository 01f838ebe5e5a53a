// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_config.h"

namespace terrace {

std::vector<std::string> StaircaseConfig::Problems() const {
  std::vector<std::string> problems;
  const auto need = [&](bool holds, const char* rule) {
    if (!holds) problems.emplace_back(rule);
  };
  need(min_riser_m > 0.0 && min_riser_m < max_riser_m, "min_riser_m must lie between 0 and max_riser_m");
  need(min_tread_m > 0.0 && min_tread_m < max_tread_m, "min_tread_m must lie between 0 and max_tread_m");
  need(min_pitch_deg > 0.0 && min_pitch_deg < max_pitch_deg && max_pitch_deg < 90.0,
       "min_pitch_deg and max_pitch_deg must rise between 0 and 90");
  need(min_width_m > 0.0, "min_width_m must be positive");
  need(min_confidence >= 0.0 && min_confidence < 1.0, "min_confidence must lie between 0 and 1");
  need(height_tolerance_m > 0.0 && height_tolerance_m < 0.5 * max_riser_m,
       "height_tolerance_m must lie between 0 and half of max_riser_m");
  need(edge_tolerance_m > 0.0 && edge_tolerance_m < min_tread_m,
       "edge_tolerance_m must lie between 0 and min_tread_m");
  need(max_turn_deg > 0.0 && max_turn_deg < 45.0, "max_turn_deg must lie between 0 and 45");
  need(max_tread_slope_deg > 0.0 && max_tread_slope_deg < 30.0,
       "max_tread_slope_deg must lie between 0 and 30");
  return problems;
}

}  // namespace terrace
