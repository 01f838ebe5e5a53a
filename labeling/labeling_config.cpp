// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/labeling_config.h"

#include "core/field_problems.h"

namespace terrace {

std::vector<std::string> RobotConfig::Problems() const {
  FieldProblems problems;
  problems.RequireUpTo("body_height_m", body_height_m, 0.0, 5.0);
  problems.RequireUpTo("max_step_height_m", max_step_height_m, 0.0, 2.0);
  problems.RequireAbove("max_step_reach_m", max_step_reach_m, 0.0);
  problems.RequireAbove("max_walkway_slope_deg", max_walkway_slope_deg, 0.0);
  problems.Require(max_ramp_slope_deg >= max_walkway_slope_deg && max_ramp_slope_deg < 60.0,
                   "max_ramp_slope_deg", max_ramp_slope_deg, "be at least max_walkway_slope_deg, below 60");
  return problems.Take();
}

std::vector<std::string> LabelingConfig::Problems() const {
  FieldProblems problems;
  problems.RequireAbove("min_walkway_edge_m", min_walkway_edge_m, 0.0);
  problems.RequireAbove("min_wall_height_m", min_wall_height_m, 0.0);
  problems.Require(min_upright_deg >= 60.0 && min_upright_deg < 90.0, "min_upright_deg", min_upright_deg,
                   "be at least 60, below 90");
  problems.RequireAtLeast("max_joint_gap_m", max_joint_gap_m, 0.0);
  problems.RequireAbove("max_joint_height_m", max_joint_height_m, 0.0);
  problems.RequireAtLeast("max_unseen_gap_m", max_unseen_gap_m, 0.0);
  problems.RequireAtLeast("min_ramp_rise_m", min_ramp_rise_m, 0.0);
  problems.RequireAbove("max_resolving_distance_m", max_resolving_distance_m, 0.0);
  problems.RequireAbove("ground_search_m", ground_search_m, 0.0);
  problems.RequireAbove("max_stance_distance_m", max_stance_distance_m, 0.0);
  problems.RequireAtLeast("min_decided_area_m2", min_decided_area_m2, 0.0);
  problems.RequireAtLeast("min_width_in_noise", min_width_in_noise, 0.0);
  problems.RequireAtLeast("frames_to_change_label", frames_to_change_label, 1);
  problems.RequireAtLeast("max_gravity_change_deg", max_gravity_change_deg, 0.0);
  return problems.Take();
}

}  // namespace terrace
