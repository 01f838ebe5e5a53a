// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/status.h"
#include "core/terrain_map.h"

namespace terrace {

/// "1.2 m ahead, 0.4 m to the left": where a point is, seen from the camera.
std::string PlaceInWords(const Eigen::Vector3d& p_world, const TerrainMap& map);

/// What differs between two maps, a sentence each: regions and area by label, staircases that came, changed
/// or went. Small corrections are not worth a word. @param before  null: everything is new
std::vector<std::string> ChangesInWords(const TerrainMapPtr& before, const TerrainMap& after);

/// One line about how the daemon is.
std::string StatusInWords(const Status& status);

/// One line about where the body is and how it moves.
std::string PoseInWords(const Eigen::Isometry3d& T_world_body, const Eigen::Vector3d& v_body);

}  // namespace terrace
