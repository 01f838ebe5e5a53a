// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/pose_estimate.h"
#include "core/terrain_map.h"
#include "polygonization/polygon.h"

namespace terrace {

/// The robot that walks on the map. YAML section: `robot`.
struct RobotConfig {
  /// Height of the body's origin above the ground it stands on.
  double body_height_m = 0.36;
  /// Highest step that the robot climbs, up or down.
  double max_step_height_m = 0.20;
  /// Widest gap that it steps over.
  double max_step_reach_m = 0.35;
  double foot_radius_m = 0.02;
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

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Decides what a planner may read each polygon as, and finds staircases.
class TerrainLabeler {
 public:
  /// @param T_body_left  where the camera sits on the body; none: the body is taken to be at the camera
  TerrainLabeler(const LabelingConfig& config, const RobotConfig& robot,
                 const std::optional<Eigen::Isometry3d>& T_body_left, std::int64_t map_id = 1);
  ~TerrainLabeler();

  /// @param pose  where the camera is now: what is reachable is reachable from there
  TerrainMapPtr Label(const PolygonUpdate& update, const PoseEstimate& pose, const Gravity& gravity);

  /// The map as last labelled; never null.
  const TerrainMapPtr& map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
