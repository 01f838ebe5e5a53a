// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/height_map_v1_t.hpp>
#include <terrace/octree_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>

#include "client/terrain_query.h"
#include "core/camera.h"
#include "core/pose_estimate.h"
#include "core/terrain_map.h"
#include "core/terrain_request.h"
#include "mapping/terrain_octree.h"
#include "stereo/disparity_image.h"

namespace terrace {

/// From what requests are answered: the state of everything after one frame.
struct AnswerSources {
  TerrainMapPtr map;        ///< never null
  std::int64_t map_id = 0;  ///< as it is published
  const StereoCamera* camera = nullptr;
  const TerrainOctree* octree = nullptr;            ///< null: there is none
  std::shared_ptr<const DisparityImage> disparity;  ///< null: the frame has none
  std::optional<Eigen::Isometry3d> T_world_left;    ///< none: not known for this frame
};

/// The box of a request in the world; none: it goes with the robot, and nobody knows where that is.
std::optional<Eigen::AlignedBox3d> BoxInWorld(const TerrainRequest& request, const AnswerSources& sources);

/// @param query  to sources.map
height_map_v1_t HeightMapAnswer(const TerrainQuery& query, std::int64_t map_id,
                                const Eigen::AlignedBox3d& box_world, double resolution_m);
/// @param leaves  of sources.octree in the box
octree_v1_t OctreeAnswer(const AnswerSources& sources, std::vector<OccupiedLeaf> leaves,
                         const Eigen::AlignedBox3d& box_world);
disparity_v1_t DisparityAnswer(const AnswerSources& sources);
/// A snapshot of the regions that reach into the box, and of the staircases that have any of them.
std::vector<terrain_v1_t> MapAnswer(const TerrainQuery& query, std::int64_t map_id,
                                    const Eigen::AlignedBox3d& box_world);

/// Cells of a height map along x and y: whole numbers.
Eigen::Vector2d NumCells(const Eigen::AlignedBox3d& box, double resolution_m);

}  // namespace terrace
