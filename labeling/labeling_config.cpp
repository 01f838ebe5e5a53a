// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/labeling_config.h"

namespace terrace {

std::vector<std::string> RobotConfig::Problems() const {
  std::vector<std::string> problems;
  const auto need = [&](bool holds, const char* rule) {
    if (!holds) problems.emplace_back(rule);
  };
  need(body_height_m > 0.0 && body_height_m <= 5.0, "body_height_m must be positive, at most 5");
  need(max_step_height_m > 0.0 && max_step_height_m <= 2.0, "max_step_height_m must be positive, at most 2");
  need(max_step_reach_m > 0.0, "max_step_reach_m must be positive");
  need(max_walkway_slope_deg > 0.0, "max_walkway_slope_deg must be positive");
  need(max_ramp_slope_deg >= max_walkway_slope_deg && max_ramp_slope_deg < 60.0,
       "max_ramp_slope_deg must lie between max_walkway_slope_deg and 60");
  return problems;
}

std::vector<std::string> LabelingConfig::Problems() const {
  std::vector<std::string> problems;
  const auto need = [&](bool holds, const char* rule) {
    if (!holds) problems.emplace_back(rule);
  };
  need(min_walkway_edge_m > 0.0, "min_walkway_edge_m must be positive");
  need(min_wall_height_m > 0.0, "min_wall_height_m must be positive");
  need(min_upright_deg >= 60.0 && min_upright_deg < 90.0, "min_upright_deg must lie between 60 and 90");
  need(max_joint_gap_m >= 0.0, "max_joint_gap_m must not be negative");
  need(max_joint_height_m > 0.0, "max_joint_height_m must be positive");
  need(max_unseen_gap_m >= 0.0, "max_unseen_gap_m must not be negative");
  need(min_ramp_rise_m >= 0.0, "min_ramp_rise_m must not be negative");
  need(max_resolving_distance_m > 0.0, "max_resolving_distance_m must be positive");
  need(ground_search_m > 0.0, "ground_search_m must be positive");
  need(max_stance_distance_m > 0.0, "max_stance_distance_m must be positive");
  need(min_decided_area_m2 >= 0.0, "min_decided_area_m2 must not be negative");
  need(min_width_in_noise >= 0.0, "min_width_in_noise must not be negative");
  need(frames_to_change_label >= 1, "frames_to_change_label must be at least 1");
  need(max_gravity_change_deg >= 0.0, "max_gravity_change_deg must not be negative");
  return problems;
}

}  // namespace terrace
