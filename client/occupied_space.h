// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <terrace/octree_v1_t.hpp>

#include "client/box_tree.h"
#include "client/terrain_query.h"

namespace terrace {

/// Whether a point lies within this distance of a seen region of the map, beside the region's own roughness:
/// three times its rms, at least 3 cm.
bool IsOnARegion(const Eigen::Vector3d& p_world, double distance_m, const TerrainQuery& query);

/// What takes up space in a box beside the regions of a map: the occupied leaves of the daemon's octree, as
/// it answers a request for them (octree_v1_t), without those that a region passes through. Where there is no
/// leaf, the octree says nothing: it keeps what there is, not what there is not.
class OccupiedSpace {
 public:
  /// @param query  to the map of the same world
  /// Throws std::runtime_error where the message holds no octree that can be read, or no box.
  OccupiedSpace(const octree_v1_t& message, const TerrainQuery& query);
  /// @param cubes_world  each takes up space; beyond `box_world` nothing is known
  OccupiedSpace(const Eigen::AlignedBox3d& box_world, std::vector<Eigen::AlignedBox3d> cubes_world);

  const Eigen::AlignedBox3d& box_world() const { return box_world_; }
  const std::vector<Eigen::AlignedBox3d>& cubes_world() const { return cubes_world_; }

  /// How near the segment from a to b comes to the nearest cube.
  struct Nearest {
    double distance_m = 0.0;  ///< negative: through the cube, and out of it by a move so far
    /// Unit: from the cube's nearest point to the segment's; of one that it passes through, the way out.
    Eigen::Vector3d away_world = Eigen::Vector3d::UnitZ();
  };
  /// None: there is no cube within `farthest_m`.
  std::optional<Nearest> NearestTo(const Eigen::Vector3d& a_world, const Eigen::Vector3d& b_world,
                                   double farthest_m) const;

 private:
  void Sort();

  Eigen::AlignedBox3d box_world_;
  std::vector<Eigen::AlignedBox3d> cubes_world_;  // in the order of the tree
  BoxTree<3> tree_;
};

}  // namespace terrace
