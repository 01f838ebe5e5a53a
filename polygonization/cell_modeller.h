// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "mapping/terrain_octree.h"
#include "polygonization/plane_moments.h"

namespace terrace {

/// Settings of the plane fits in cells. YAML section: `modelling`.
struct ModellingConfig {
  /// A leaf whose points lie closer to a plane than this, or than three times their noise, belongs to it.
  double inlier_distance_m = 0.012;
  /// The noise is never taken to explain more than this.
  double max_inlier_distance_m = 0.12;
  /// Leaves of a plane lie near its middle: the root mean square of their distances is below this share of
  /// what is allowed. (Leaves scattered evenly would have 0.58.)
  double max_rms_share = 0.45;
  /// A patch covers at least this area.
  double min_patch_area_m2 = 0.0015;
  /// Planes looked for in one cell.
  int max_planes = 5;
  /// Three-leaf hypotheses tried for each plane.
  int num_hypotheses = 24;
  /// Leaves on which a hypothesis is tried before it is tried on all.
  int num_pretest = 40;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// What one leaf covers: a rectangle in the plane of its patch.
struct Footprint {
  Eigen::Vector3f centre;  ///< relative to the centre of the cell [m]
  Eigen::Vector3f half_x;  ///< from the centre to the middle of one edge
  Eigen::Vector3f half_y;
};

/// One planar piece inside one cell.
struct Patch {
  Plane plane_world;     ///< the normal points to the side that was seen
  PlaneMoments moments;  ///< relative to the centre of the cell
  double area_m2 = 0.0;  ///< of the rectangles that its leaves cover
  /// Box around these rectangles, relative to the centre of the cell [m].
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = Eigen::Vector3f::Zero();
  double num_frames = 0.0;  ///< mean over its leaves
  double noise_m = 0.0;     ///< of single points, along the normal; the best leaves count most
  /// What that noise may be at worst: by how much a neighbouring patch of the same surface may stand off.
  double most_noise_m = 0.0;
  std::vector<Footprint> footprints;
};

/// The new patches of the cells that changed; a cell without patches has lost its planes.
struct PatchUpdate {
  struct CellPatches {
    CellKey key;
    Eigen::Vector3d centre_world = Eigen::Vector3d::Zero();
    std::vector<Patch> patches;
  };
  FrameId frame_id = 0;
  Timestamp t_capture;
  std::vector<CellPatches> cells;  ///< ascending by key
};

/// Fits planes to the points of each changed cell, cells in parallel, any number of threads with the same
/// result. Planes found before, in the cell or beside it, are tried first: a tread that ends a little way
/// into a cell is found there by the plane that the next cell knows well.
class CellModeller {
 public:
  explicit CellModeller(const ModellingConfig& config);

  PatchUpdate Fit(const TerrainOctree& octree, const ChangedCells& cells);
  /// Forgets the planes of these cells, whose points are gone.
  void Forget(const std::vector<CellKey>& cells) {
    for (const CellKey& key : cells) planes_world_.erase(key);
  }
  /// Forgets the planes of all cells: a new map begins.
  void Reset() { planes_world_.clear(); }

 private:
  std::vector<Plane> HintsFor(const CellKey& key, const Eigen::Vector3d& centre_world,
                              double cell_size_m) const;

  ModellingConfig config_;
  std::map<CellKey, std::vector<Plane>> planes_world_;  // of each cell, as last fitted
};

}  // namespace terrace
