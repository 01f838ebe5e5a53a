// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/terrain_map.h"
#include "datasets/ground_truth.h"

namespace terrace {

/// A true rectangle of nx x ny whole cells of 4 cm, all of them seen, from `corner` along two unit axes; the
/// normal is axis_x cross axis_y.
TruePolygon Rectangle(int id, const std::string& label, const Eigen::Vector3d& corner,
                      const Eigen::Vector3d& axis_x, const Eigen::Vector3d& axis_y, int nx, int ny);

/// Cells of the small world, by hand:
///   1  floor    walkway      100 x 50 = 5000
///   2  wall     wall         100 x 50 = 5000
///   3  chest    obstacle      20 x 10 =  200
///   11..15 risers stair_riser 4 x 35 =  140 each,  700 together
///   21..30 treads stair_tread 7 x 35 =  245 each, 2450 together (ten, so that one is a tenth)
/// The stairs are ten treads with a riser below every second one only, which is enough for cells; the
/// staircase says eleven risers of 0.16 m. Support (|normal z| > 0.7): floor, chest and treads, 7650 cells.
/// All: 13350.
TrueScene SmallWorld();
inline constexpr int kSmallWorldCells = 13350;
inline constexpr int kSmallWorldSupportCells = 7650;

/// The truth as if a daemon had reported it.
TerrainMap MapOf(const TrueScene& scene);

/// The map with another region in the place of region `id`, or without it when `edit` is empty.
TerrainMap WithRegion(const TerrainMap& map, std::int64_t id, void (*edit)(TerrainRegion&));

/// The map seen from another world: p_new = T_new_old * p_old.
TerrainMap Transformed(const Eigen::Isometry3d& T_new_old, const TerrainMap& map);

}  // namespace terrace
