// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>
#include <terrace/heightmap_t.hpp>
#include <terrace/localization_lcmt.hpp>
#include <terrace/traversability_map_t.hpp>

#include "client/query_types.h"
#include "client/terrain_query.h"

namespace terrace {

/// What MIT's Cheetah-Software hears of the ground around its robot. Its world is ours, lifted so that the
/// ground that the robot stood on first is at z = 0.
struct CheetahMaps {
  heightmap_t heights{};
  traversability_map_t traversability{};
};

/// Numbers of traversability_map_t: the walker sets its feet where there is a zero, and nowhere else.
inline constexpr int kMayStand = 0;
inline constexpr int kMayNotStand = 1;   ///< known, and not fit for a foot
inline constexpr int kUnseenGround = 2;  ///< nobody has seen it

/// 100 x 100 cells of 0.015 m with [50][50] under the body. Heights of cells that nobody has seen say
/// nothing: they have that of the ground under the robot, so that no obstacle is made up, and no foot may
/// stand there.
/// @param ground_z_world  height that is called zero
CheetahMaps CheetahMapsOf(const TerrainQuery& query, const Eigen::Isometry3d& T_world_body,
                          double ground_z_world, const FootSpec& foot);
/// While it is not known where the robot is: nothing is known.
CheetahMaps CheetahMapsOfNothing(const Eigen::Vector3d& body_world, double ground_z_world);

localization_lcmt CheetahLocalization(const Eigen::Isometry3d& T_world_body, double ground_z_world);

/// The height of the ground under the body; none: nothing is known there.
std::optional<double> GroundUnder(const TerrainQuery& query, const Eigen::Vector3d& body_world);

}  // namespace terrace
