// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry.h"
#include "mapping/terrain_octree.h"

namespace terrace {

/// Settings of the plane fits in cells. YAML section: `modelling`.
struct ModellingConfig {
  /// Planes closer to the cell's points than this explain them.
  double inlier_distance_m = 0.02;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// One planar piece inside one cell.
struct Patch {
  Plane plane_world;
};

/// The new patches of the cells that changed; a cell without patches has lost its planes.
struct PatchUpdate {
  struct CellPatches {
    CellKey key;
    std::vector<Patch> patches;
  };
  FrameId frame_id = 0;
  Timestamp t_capture;
  std::vector<CellPatches> cells;  ///< ascending by key
};

/// Fits planes to the points of each changed cell, cells in parallel, any number of threads with the same
/// result.
class CellModeller {
 public:
  explicit CellModeller(const ModellingConfig& config);

  PatchUpdate Fit(const TerrainOctree& octree, const ChangedCells& cells) const;

 private:
  ModellingConfig config_;
};

}  // namespace terrace
