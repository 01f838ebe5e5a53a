// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/time.h"

namespace terrace {

/// Whether it is known where a loaded map lies in the world. The numbers are those of map_transform_v1_t.
enum class MapPlacing : std::int8_t {
  kNotFound = 0,   ///< it is not: the loaded map stands by itself, in its own frame
  kGiven = 1,      ///< as somebody said; what is seen has not confirmed it
  kConfirmed = 2,  ///< what is seen has confirmed it, and says how exactly
  /// By the views that were saved with it; its surfaces have not confirmed it.
  kRecognised = 3,
};
inline constexpr int kNumMapPlacings = 4;
const char* Name(MapPlacing placing);  ///< "not_found", "given", "confirmed", "recognised"

/// Where a map that was loaded lies in the world of the poses.
struct MapTransform {
  Timestamp t;              ///< newest image when this was known
  std::int64_t map_id = 0;  ///< of the terrain that holds the loaded map; 0: none does
  std::string file;         ///< that was loaded
  MapPlacing placing = MapPlacing::kNotFound;
  std::string reason;  ///< why not found or not confirmed; empty when confirmed
  /// From the world into the frame of the loaded map: p_map = T_map_world * p_world. Without meaning when not
  /// found.
  Eigen::Isometry3d T_map_world = Eigen::Isometry3d::Identity();
  /// Of its error: rotation [rad], translation [m]; axes of the world, about its origin.
  Matrix6d covariance = Matrix6d::Zero();
};

}  // namespace terrace
