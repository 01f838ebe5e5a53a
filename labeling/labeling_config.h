// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

/// The robot that walks on the map. YAML section: `robot`.
struct RobotConfig {
  /// Height of the body's origin above the ground it stands on.
  double body_height_m = 0.36;
  /// Highest step that the robot climbs, up or down.
  double max_step_height_m = 0.20;
  /// Widest gap that it steps over.
  double max_step_reach_m = 0.35;
  /// Steepest slope for the ordinary gait.
  double max_walkway_slope_deg = 8.0;
  /// Steepest slope that it walks at all.
  double max_ramp_slope_deg = 30.0;
  /// PNG of the rectified left image's size, black where the robot sees its own legs; empty: none.
  std::string self_mask_png;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Settings of the labels. YAML section: `labeling`.
struct LabelingConfig {
  /// A walkway must hold a square of this edge.
  double min_walkway_edge_m = 0.5;
  /// An upright face that rises higher than this above the ground at its foot is a wall.
  double min_wall_height_m = 1.0;
  /// A face is upright when it leans no more than this from level, counted from the ground.
  double min_upright_deg = 65.0;
  /// Level pieces with a smaller gap and a smaller step between them are one piece of ground.
  double max_joint_gap_m = 0.10;
  double max_joint_height_m = 0.04;
  /// Ground that goes on at the same height behind a strip that was not seen, no wider than this, counts as
  /// reachable.
  double max_unseen_gap_m = 1.0;
  /// A slope that rises less than this from end to end is uneven ground, not a ramp.
  double min_ramp_rise_m = 0.06;
  /// From farther away the top of a face cannot be told from where matching ends.
  double max_resolving_distance_m = 4.0;
  /// The ground at the foot of a face or beside a top is looked for this far away.
  double ground_search_m = 0.4;
  /// The ground under the robot, which it never sees, is taken to go on in what lies nearest, within this.
  double max_stance_distance_m = 2.0;
  /// Smaller pieces stay unknown unless they are part of a staircase or continue their neighbours.
  double min_decided_area_m2 = 0.04;
  /// Regions narrower than this many times their noise are not told, unless they are part of a staircase: far
  /// away, noise makes up planes.
  double min_width_in_noise = 10.0;
  /// A label changes when this many frames in a row say so; a staircase appears after as many, or after two
  /// that leave little doubt.
  int frames_to_change_label = 3;
  /// Heights are measured again when what is known of gravity has turned by more than this.
  double max_gravity_change_deg = 0.2;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
