// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "client/query_types.h"
#include "client/terrain_query.h"
#include "core/terrain_map.h"

namespace terrace {

/// One step of a staircase: the tread, or behind the last riser the beginning of the landing, above riser
/// `index`.
struct StairStep {
  int index = 0;         ///< 1: the lowest
  bool landing = false;  ///< no tread of the flight: what the last riser leads to
  /// Origin in the middle of the nose, x level and up the stairs, z up.
  Eigen::Isometry3d T_world_step = Eigen::Isometry3d::Identity();
  std::array<Eigen::Vector3d, 2> nose_world{
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};  ///< left and right end, looking up the stairs
  double depth_m = 0.0;                                   ///< by the flight's law; landing: of a tread
  double depth_sigma_m = 0.0;
  double width_m = 0.0;
  double sigma_height_m = 0.0;  ///< of the nose's height: by the tread's plane, else by the law
  /// Whether a region of the map shows it, instead of the law of the flight alone.
  bool seen = false;
  std::optional<std::int64_t>
      region_id;  ///< of the map, seen or predicted; none: it has no region of its own
};

/// Where gaits change: where to stand before the first or after the last step.
struct StairStand {
  Eigen::Vector3d point_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d heading_up = Eigen::Vector2d::UnitX();  ///< unit, up the stairs
  std::optional<Support> ground;                          ///< none: nothing is known there
};

struct StairPlan {
  std::vector<StairStep> steps;  ///< from the lowest; as many as there are risers
  StairStand before;             ///< in front of the first riser
  StairStand after;              ///< behind the last one
};

/// Every step of a staircase, also those that were not seen, in the order of climbing.
/// @param stand_off_m  from the first and from the last riser to where the robot stands
StairPlan StepsOf(const TerrainQuery& query, const Staircase& stairs, double stand_off_m = 0.4);

}  // namespace terrace
