// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_config.h"

#include "core/field_problems.h"

namespace terrace {

std::vector<std::string> StaircaseConfig::Problems() const {
  FieldProblems problems;
  problems.Require(min_riser_m > 0.0 && min_riser_m < max_riser_m, "min_riser_m", min_riser_m,
                   "be above 0, below max_riser_m");
  problems.Require(min_tread_m > 0.0 && min_tread_m < max_tread_m, "min_tread_m", min_tread_m,
                   "be above 0, below max_tread_m");
  problems.Require(min_pitch_deg > 0.0 && min_pitch_deg < max_pitch_deg, "min_pitch_deg", min_pitch_deg,
                   "be above 0, below max_pitch_deg");
  problems.Require(max_pitch_deg < 90.0, "max_pitch_deg", max_pitch_deg, "be below 90");
  problems.RequireAbove("min_width_m", min_width_m, 0.0);
  problems.Require(min_confidence >= 0.0 && min_confidence < 1.0, "min_confidence", min_confidence,
                   "be at least 0, below 1");
  problems.Require(height_tolerance_m > 0.0 && height_tolerance_m < 0.5 * max_riser_m, "height_tolerance_m",
                   height_tolerance_m, "be above 0, below half of max_riser_m");
  problems.Require(edge_tolerance_m > 0.0 && edge_tolerance_m < min_tread_m, "edge_tolerance_m",
                   edge_tolerance_m, "be above 0, below min_tread_m");
  problems.RequireInside("max_turn_deg", max_turn_deg, 0.0, 45.0);
  problems.RequireInside("max_tread_slope_deg", max_tread_slope_deg, 0.0, 30.0);
  return problems.Take();
}

}  // namespace terrace
