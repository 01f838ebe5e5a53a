// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "terrace/client/query_types.h"
#include "terrace/client/terrain_query.h"

namespace terrace {

/// What a robot can do with a step. Two feet side by side stand for the pairs of a robot with more.
struct Walker {
  FootSpec foot;
  double stance_width_m = 0.3;     ///< between the left and the right foot
  double stride_m = 0.3;           ///< the furthest that a foot is set before the other one
  double max_step_height_m = 0.2;  ///< from the one foot to the other, up or down
  double turn_rad = M_PI / 12.0;   ///< the most that one step turns
  double snap_m = 0.06;            ///< how far from where it would like to a foot may be set
  /// The body's box over the way that a step takes it, from the higher foot: nothing may reach into it.
  double body_bottom_m = 0.35;
  double body_top_m = 0.6;
  double body_half_width_m = 0.15;
};

struct Footstep {
  bool left = false;
  double heading_rad = 0.0;  ///< of the walker, in the plan
  Support ground;
};

/// Where to go: the middle between the feet.
struct PlanEnd {
  Eigen::Vector3d ground_world = Eigen::Vector3d::Zero();
  double heading_rad = 0.0;  ///< of the start; the goal's does not count
};

/// Footholds from start to goal by A*: a short way (at most half longer than the shortest), with a price on
/// height. The first two are the feet at the start. Empty: there is no way, or none was found within
/// `max_expansions` states.
std::vector<Footstep> PlanFootsteps(const TerrainQuery& query, const Walker& walker, const PlanEnd& start,
                                    const PlanEnd& goal, int max_expansions = 100000);

}  // namespace terrace
