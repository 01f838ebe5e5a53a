// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <octomap/AbstractOcTree.h>
#include <octomap/OcTreeBaseImpl.h>
#include <octomap/OcTreeDataNode.h>

#include "core/time.h"
#include "mapping/frame_leaves.h"
#include "mapping/leaf_address.h"
#include "mapping/leaf_pool.h"
#include "mapping/mapping_config.h"

namespace terrace {

/// The leaves of one cell, and how much they have changed since the cell was last reported.
struct Cell {
  CellKey key;
  std::vector<int> leaves;     ///< in the order of the octree
  float weight = 0.0F;         ///< all that was ever added
  float fitted_weight = 0.0F;  ///< `weight` when the cell was last reported
  int num_changed_leaves = 0;  ///< occupied or no longer, since it was last reported
  FrameId reported_frame = -1000;
  FrameId touched_frame = -1;
};

/// The octree on OctoMap down to the cells; below, a cell lists its leaves in the order in which the octree
/// would be walked, which takes a tenth of the memory of nodes. Leaves and cells are kept in pools and
/// addressed by their slots, which are used again when what they held has gone.
///
/// What always holds: a leaf is listed in its cell in the order of the octree; a node without value and
/// children does not exist; no two places of the tree are more than 65,536 leaves apart (ForgetBeyond sees to
/// it).
class LeafTree {
 public:
  /// The value of a node is the slot of a Cell at the depth of cells, kNothing above.
  class Node : public octomap::OcTreeDataNode<int> {
   public:
    Node() : octomap::OcTreeDataNode<int>(kNothing) {}

    bool HasArrayOfChildren() const { return children != nullptr; }
    /// OctoMap keeps the array of children when the last child is deleted, and expects it gone with the node.
    /// True when there was one to be released.
    bool ReleaseEmptyChildren();
  };

  explicit LeafTree(const MappingConfig& config);

  /// Slots of cells, free ones among them, which have no leaves.
  int num_cell_slots() const { return cells_.num_slots(); }
  Cell& cell(int slot) { return cells_[slot]; }
  const Cell& cell(int slot) const { return cells_[slot]; }
  LeafPool& leaves() { return leaves_; }
  const LeafPool& leaves() const { return leaves_; }
  std::int64_t memory_bytes() const;

  CellKey CellOf(const LeafIndex& index) const;
  /// Lowest corner of a cell.
  LeafIndex CornerOf(const CellKey& key) const;
  /// Slot of a cell; kNothing where there is none.
  int FindCell(const CellKey& key) const;

  /// Finds a leaf of the frame, where an earlier frame found it or by walking down to it, and makes it when
  /// there is none; no leaf where the place is known more finely already. Coarser leaves on the way are
  /// marked as hit, too.
  LeafPlace FindOrMake(const FrameLeaf& seen, const CellKey& cell, FrameId frame_id);
  /// Takes the coarser leaves out that the last FindOrMake came by.
  void DropCoarser(Cell* cell);
  /// Takes the leaves out that are not occupied, and gives back the room that the cell's list does not need.
  void DropUnoccupied(Cell* cell);

  /// Calls `use(slot, corner)` for each cell below nodes for which `inside(corner, size)` holds; corner
  /// is the lowest one, nearest to `near`; both in finest leaves.
  template <typename Inside, typename Use>
  void ForEachCell(const LeafIndex& near, const Inside& inside, const Use& use) {
    if (tree_.getRoot() != nullptr) Visit(tree_.getRoot(), 0, Corner::Zero(), near, inside, use);
  }
  /// Gives the slot of a cell without leaves back.
  void RemoveCell(const CellKey& key);
  /// Forgets blocks of cells that lie farther away than this in plan and height, at most `max_blocks` of
  /// them.
  /// @return the cells that are gone, ascending
  std::vector<CellKey> ForgetBeyond(const LeafIndex& centre, int radius_leaves, int max_blocks);

 private:
  /// OctoMap's own OcTreeBase does not compile as C++20.
  class Tree : public octomap::OcTreeBaseImpl<Node, octomap::AbstractOcTree> {
   public:
    explicit Tree(double leaf_size_m) : OcTreeBaseImpl(leaf_size_m) {}

    Tree* create() const override { return new Tree(resolution); }
    std::string getTreeType() const override { return "TerraceTree"; }

    Node* MakeRoot();
    Node* GetOrMakeChild(Node* node, unsigned child);
    void DeleteChild(Node* node, unsigned child);
    /// OctoMap's own memoryUsage() walks the whole tree.
    std::int64_t memory_bytes() const;

   private:
    std::int64_t num_arrays_ = 0;
  };

  using Corner = Eigen::Vector3i;  // lowest one of a node, as keys

  static constexpr unsigned kDepth = 16;
  static constexpr unsigned kBlockDepth = kDepth - 6;  // blocks of 64 finest leaves

  static unsigned ChildIndex(const octomap::OcTreeKey& key, unsigned child_depth);
  static octomap::OcTreeKey KeyAt(const LeafIndex& index);
  static Corner CornerOfChild(const Corner& corner, unsigned child_depth, unsigned child);
  static LeafIndex IndexNear(const Corner& corner, int size, const LeafIndex& near);

  /// Slot of a cell, which is made when there is none.
  int CellAt(const CellKey& key);
  void GiveBackCell(int slot);
  /// Whether a leaf is where an earlier frame found it, and without coarser ones above it.
  bool IsStill(const FrameLeaf& seen, const CellKey& cell) const;
  void DeleteBelow(Node* node, unsigned depth, std::vector<CellKey>* forgotten);
  /// Deletes the nodes on the way to a node of `depth` that hold nothing any more.
  void DeleteEmptyPath(const octomap::OcTreeKey& key, unsigned depth);

  template <typename Inside, typename Use>
  void Visit(Node* node, unsigned depth, const Corner& corner, const LeafIndex& near, const Inside& inside,
             const Use& use) {
    if (depth > 0 && !inside(IndexNear(corner, 1 << (kDepth - depth), near), 1 << (kDepth - depth))) return;
    if (depth == cell_depth_) {
      use(node->getValue(), IndexNear(corner, 1 << (kDepth - depth), near));
      return;
    }
    for (unsigned child = 0; child < 8; ++child)
      if (tree_.nodeChildExists(node, child))
        Visit(tree_.getNodeChild(node, child), depth + 1, CornerOfChild(corner, depth + 1, child), near,
              inside, use);
  }

  const int leaves_per_cell_;
  const int cell_shift_;
  const unsigned cell_depth_;
  Tree tree_;
  LeafPool leaves_;
  Pool<Cell> cells_;
  std::vector<int> coarser_;  // leaves that hold the one that was found last
  CellKey last_cell_key_;
  int last_cell_ = kNothing;
  std::int64_t list_bytes_ = 0;  // of the cells' lists of leaves
};

}  // namespace terrace
