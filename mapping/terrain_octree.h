// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/pose_estimate.h"
#include "mapping/leaf_address.h"
#include "mapping/mapping_config.h"
#include "mapping/octomap_bytes.h"
#include "stereo/cloud.h"

namespace terrace {

/// What a leaf of the octree knows of the surface in it: a small piece of surface with its noise.
struct Surfel {
  Eigen::Vector3f mean;        ///< of the points, relative to the centre of the cell [m]
  Eigen::Matrix3f covariance;  ///< of the points about the mean, noise included [m^2]
  Eigen::Vector3f view;        ///< mean unit direction from the camera to the points, world axes
  float sigma_view_m;          ///< noise of one point along `view`
  float num_points;            ///< number of points behind the mean, old ones faded
  float num_frames;            ///< number of frames behind it, old ones faded
  float size_m;                ///< edge of the leaf
  float spacing_m;             ///< finest spacing of the pixels across the view, at the surface
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
  explicit TerrainOctree(const MappingConfig& config);
  ~TerrainOctree();

  /// Adds one frame's points, and clears what they prove to be free. The cost depends on the frame, not on
  /// the size of the map. Returned are the cells that changed enough to be worth a new fit.
  ChangedCells Insert(const Cloud& cloud, const StereoCamera& camera, const PoseEstimate& pose);
  /// Forgets what lies farther than this from a place, a few blocks at a time.
  /// @return the cells that are gone, ascending
  std::vector<CellKey> ForgetBeyond(const Eigen::Vector3d& p_world, double radius_m);

  /// The occupied leaves of one cell, always in the same order.
  void CollectSurfels(const CellKey& cell, std::vector<Surfel>* surfels) const;
  /// The occupied leaves that reach into a box, which may be no larger than the window; always in the same
  /// order.
  std::vector<OccupiedLeaf> LeavesIn(const Eigen::AlignedBox3d& box_world) const;
  double leaf_size_m() const { return config_.leaf_size_m; }
  Eigen::Vector3d CellCentre(const CellKey& cell) const;
  double cell_size_m() const { return config_.cell_size_m(); }

  std::int64_t num_leaves() const;  ///< occupied or not
  std::int64_t num_occupied_leaves() const;
  std::int64_t memory_bytes() const;

 private:
  class Impl;
  MappingConfig config_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
