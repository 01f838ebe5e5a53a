// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/pose_estimate.h"
#include "stereo/cloud.h"

namespace terrace {

/// Weighted sums over the points of one leaf, from which means, covariances and planes follow without the
/// points. Points are taken relative to the leaf's centre, so that the sums keep their digits far from the
/// origin.
struct PointMoments {
  double weight = 0.0;                                  ///< sum of 1 / variance [1/m^2]
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();        ///< weight * p
  Eigen::Matrix3d sum_outer = Eigen::Matrix3d::Zero();  ///< weight * p * p^T
  int num_points = 0;
};

/// Address of a cell: the octree node of `cell_size_m` that holds it, counted from the world's origin.
struct CellKey {
  int x = 0, y = 0, z = 0;
  friend constexpr auto operator<=>(const CellKey&, const CellKey&) = default;
};

/// Settings of the spatial decomposition. YAML section: `mapping`.
struct MappingConfig {
  /// Edge of an octree leaf, in which points are summed.
  double leaf_size_m = 0.04;
  /// Leaves along the edge of a cell, in which planes are fitted; a power of two.
  int leaves_per_cell = 8;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// The cells whose points changed with one frame.
struct ChangedCells {
  FrameId frame_id = 0;
  Timestamp t_capture;
  std::vector<CellKey> keys;  ///< ascending, each once
};

/// The points of all frames, summed in the leaves of an octree in the world frame; what has gone is cleared.
class TerrainOctree {
 public:
  TerrainOctree(const MappingConfig& config, const StereoCamera& camera);
  ~TerrainOctree();

  /// Adds one frame's points. The cost depends on the frame, not on the size of the map.
  ChangedCells Insert(const Cloud& cloud, const PoseEstimate& pose);

  std::int64_t num_occupied_leaves() const;
  std::int64_t memory_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
