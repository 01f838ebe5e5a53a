// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

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
  /// Within this distance of the camera the map keeps its evidence, from which it can still change; beyond,
  /// the regions stay as they are.
  double window_m = 12.0;
  /// Regions farther from the camera than this are forgotten for good; 0: none ever is.
  double keep_beyond_m = 0.0;

  double cell_size_m() const { return leaf_size_m * leaves_per_cell; }
  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
