// SPDX-License-Identifier: BSD-3-Clause
#include "client/example/footsteps/plan_message.h"

namespace terrace {

footstep_plan_v1_t PlanMessage(const TerrainMap& map, const std::vector<Footstep>& steps,
                               double foot_radius_m) {
  footstep_plan_v1_t plan{};
  plan.utime = map.t_capture.utime();
  plan.map_id = map.map_id;
  plan.map_seq = map.seq;
  plan.frame_id = "world";
  plan.foot_radius = static_cast<float>(foot_radius_m);
  plan.n_steps = static_cast<std::int32_t>(steps.size());
  bool before_on_tread = false;
  for (const Footstep& step : steps) {
    const Support& ground = step.ground;
    const bool on_tread = ground.label == TerrainLabel::kStairTread;
    plan.side.push_back(step.left ? footstep_plan_v1_t::LEFT : footstep_plan_v1_t::RIGHT);
    plan.pos.push_back({ground.point_world.x(), ground.point_world.y(), ground.point_world.z()});
    plan.normal.push_back({ground.normal_world.x(), ground.normal_world.y(), ground.normal_world.z()});
    plan.heading.push_back(step.heading_rad);
    plan.sigma_height.push_back(static_cast<float>(ground.sigma_height_m));
    plan.label.push_back(static_cast<std::int8_t>(ground.label));
    plan.region_id.push_back(ground.region_id);
    plan.gait.push_back(on_tread || before_on_tread ? footstep_plan_v1_t::CLIMB : footstep_plan_v1_t::WALK);
    before_on_tread = on_tread;
  }
  return plan;
}

}  // namespace terrace
