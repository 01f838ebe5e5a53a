// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "core/terrain_map.h"

namespace terrace {

/// Where the body is in a loaded map, as somebody says.
struct BodyInMap {
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();  ///< m
  double yaw_rad = 0.0;                             ///< of the body's x axis, from the map's x towards its y
  /// How well people measure such a thing.
  double sigma_p_m = 0.05;
  double sigma_yaw_rad = 2.0 * M_PI / 180.0;
};
/// Of "x y z yaw": metres, and degrees; none when it is not four numbers.
std::optional<BodyInMap> BodyInMapFrom(const std::string& text);

/// Where the left camera is in a loaded map, as the views that were saved with it say.
struct CameraInMap {
  Eigen::Isometry3d T_map_left = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< rotation [rad], translation [m]; left frame
  int num_corners = 0;                     ///< that were recognised
};

/// Where a map lies in the world: p_map = T_map_world * p_world.
struct MapPlace {
  Eigen::Isometry3d T_map_world = Eigen::Isometry3d::Identity();
  Matrix6d covariance =
      Matrix6d::Zero();  ///< rotation [rad], translation [m]; axes of the world, at its origin
};

/// By where the body is in both; up is up in both, each by its own gravity.
MapPlace PlaceOf(const BodyInMap& body_in_map, const Eigen::Isometry3d& T_world_body,
                 const Gravity& gravity_world, const Gravity& gravity_map);
/// By where the camera is in both.
MapPlace PlaceOf(const CameraInMap& camera_in_map, const Eigen::Isometry3d& T_world_left);

/// Whether what it is has been decided by what was seen.
bool IsDecided(const TerrainRegion& region);

/// The region as it lies in the world, with what the place is uncertain by in its plane's covariance.
TerrainRegion Placed(const TerrainRegion& region_map, const MapPlace& place);
Staircase Placed(const Staircase& staircase_map, const MapPlace& place);

}  // namespace terrace
