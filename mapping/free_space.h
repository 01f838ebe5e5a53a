// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/time.h"
#include "mapping/leaf_tree.h"
#include "mapping/mapping_config.h"
#include "mapping/view_tiles.h"

namespace terrace {

/// The checks of one frame: leaves in the field of view are told occupied or not, and those behind which the
/// image keeps showing something are cleared. Space is not traced ray by ray: leaves are projected into the
/// image.
class FreeSpace {
 public:
  FreeSpace(const MappingConfig& config, const StereoCamera& camera, const Eigen::Isometry3d& T_world_left,
            FrameId frame_id, const ViewTiles& tiles);

  /// Calls `use(cell)` for every cell in which leaves became occupied or no longer are.
  template <typename Use>
  void Check(LeafTree* tree, const Use& use) {
    tree->ForEachCell(
        camera_leaf_, [this](const LeafIndex& corner, int size) { return MayBeInView(corner, size); },
        [&](int slot, const LeafIndex& corner) {
          Cell& cell = tree->cell(slot);
          if (!HasItsTurn(cell.key)) return;
          const int before = cell.num_changed_leaves;
          CheckLeaves(corner, &cell, tree);
          if (cell.num_changed_leaves != before) use(&cell);
        });
  }

 private:
  Eigen::Vector3d CentreInLeft(const LeafIndex& corner, int size) const;
  bool MayBeInView(const LeafIndex& corner, int size) const;
  /// Cells take turns, so that a frame checks one in so many.
  bool HasItsTurn(const CellKey& key) const;
  void CheckLeaves(const LeafIndex& corner, Cell* cell, LeafTree* tree) const;
  enum class LeafState {
    kOccupied,
    kNoise,    ///< or hardly known
    kCleared,  ///< seen through too often
  };
  LeafState CheckLeaf(const Eigen::Vector3i& in_cell, const Eigen::Vector3f& corner_left,
                      Evidence* leaf) const;
  bool IsOccupied(const Evidence& leaf) const;

  const MappingConfig& config_;
  const ViewTiles& tiles_;
  const FrameId frame_id_;
  const LeafIndex camera_leaf_;
  const Eigen::Isometry3d T_left_world_;
  const Eigen::Matrix3f R_left_leaves_;   // times the size of a leaf
  std::array<Eigen::Vector3d, 4> sides_;  // inward normals of the planes through the camera and an image edge
  double farthest_m_ = 0.0;
};

}  // namespace terrace
