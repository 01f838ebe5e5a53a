// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "core/camera.h"
#include "mapping/frame_leaves.h"
#include "mapping/leaf_address.h"
#include "mapping/mapping_config.h"
#include "mapping/view_tiles.h"
#include "stereo/cloud.h"

namespace terrace {

/// Whether leaves can be counted as far as this.
bool IsCountable(const Eigen::Vector3d& p_world, const MappingConfig& config);
/// The finest leaf that holds a point of the world; it must be countable.
LeafIndex LeafAt(const Eigen::Vector3d& p_world, const MappingConfig& config);

/// Sums the points of one frame in the leaves that they lie in, and tells the tiles how near the image shows
/// something. A leaf is as large as at least `min_leaf_px` pixels are at its distance. Points that are no
/// numbers, or too far away for the octree, are left out.
void SumPoints(const Cloud& cloud, const StereoCamera& camera, const Eigen::Isometry3d& T_world_left,
               const MappingConfig& config, FrameLeaves* leaves, ViewTiles* tiles);

}  // namespace terrace
