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

/// Address of a cell: the octree node of `cell_size_m` that holds it, counted from the world's origin.
struct CellKey {
  int x = 0, y = 0, z = 0;
  friend constexpr auto operator<=>(const CellKey&, const CellKey&) = default;
};

/// Settings of the spatial decomposition. YAML section: `mapping`.
struct MappingConfig {
  /// Edge of the finest octree leaf, in which points are summed. What is seen from farther away goes into
  /// leaves of twice, four times the size.
  double leaf_size_m = 0.02;
  /// Finest leaves along the edge of a cell, in which planes are fitted; a power of two, at least 4.
  int leaves_per_cell = 16;
  /// A leaf is at least this many pixels wide in the image that fills it.
  double min_leaf_px = 5.0;
  /// Points that a leaf needs before it counts as occupied.
  int min_points = 4;
  /// Frames that must have put points into it.
  int min_frames = 2;
  /// A leaf in view that fewer frames than this share put points into holds noise.
  double min_hit_share = 0.3;
  /// Neighbouring pixels err together, more than each one's sigma says: sigmas of depth are taken this much
  /// larger.
  double depth_sigma_factor = 1.5;
  /// What the pose of a frame adds to the error of its points.
  double pose_sigma_m = 0.002;
  /// A leaf remembers about this many frames; older ones fade, so that new ones can still move it.
  int memory_frames = 60;
  /// A leaf is seen through when what the image shows there lies behind it by this much disparity.
  double free_margin_px = 1.0;
  /// A leaf that is seen through in this many frames more than it is hit in is cleared.
  int free_frames = 4;

  double cell_size_m() const { return leaf_size_m * leaves_per_cell; }
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

  /// Adds one frame's points, and clears what they prove to be free. The cost depends on the frame, not on
  /// the size of the map. Returned are the cells that changed enough to be worth a new fit.
  ChangedCells Insert(const Cloud& cloud, const PoseEstimate& pose);

  /// The occupied leaves of one cell, always in the same order.
  void CollectSurfels(const CellKey& cell, std::vector<Surfel>* surfels) const;
  Eigen::Vector3d CellCentre(const CellKey& cell) const;
  double cell_size_m() const { return config_.cell_size_m(); }

  std::int64_t num_occupied_leaves() const;
  std::int64_t memory_bytes() const;

 private:
  class Impl;
  MappingConfig config_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
