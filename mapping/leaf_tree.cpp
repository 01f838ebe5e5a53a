// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/leaf_tree.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/check.h"

namespace terrace {
namespace {

using Corner8 = std::array<std::uint8_t, 3>;  // of a leaf, from the lowest one of its cell

constexpr int kOrders = 8;  // of leaves that begin at one corner

/// Two bits of nothing between the six of a number.
unsigned Spread(unsigned bits) {
  bits = (bits | bits << 8U) & 0x300FU;
  bits = (bits | bits << 4U) & 0x30C3U;
  return (bits | bits << 2U) & 0x9249U;
}

/// Where a leaf of a cell comes when the octree is walked: eighth by eighth, coarse ones before what they
/// hold.
int Rank(const Corner8& corner, int level) {
  const unsigned order = Spread(corner[0]) | Spread(corner[1]) << 1U | Spread(corner[2]) << 2U;
  return kOrders * static_cast<int>(order) + kOrders - 1 - level;
}

/// The first leaf of a cell that does not come before a rank.
std::vector<int>::iterator FirstFrom(int rank, const LeafPool& leaves, std::vector<int>* in_cell) {
  return std::lower_bound(in_cell->begin(), in_cell->end(), rank, [&](int other, int wanted) {
    return Rank(leaves.evidence(other).corner, leaves.evidence(other).level) < wanted;
  });
}

Corner8 CornerInCell(const LeafAddress& address, int leaves_per_cell) {
  const int in_cell = leaves_per_cell - 1;
  return {static_cast<std::uint8_t>(address.x() & in_cell), static_cast<std::uint8_t>(address.y() & in_cell),
          static_cast<std::uint8_t>(address.z() & in_cell)};
}

}  // namespace

bool LeafTree::Node::ReleaseEmptyChildren() {
  if (children == nullptr ||
      std::any_of(children, children + 8, [](auto* child) { return child != nullptr; }))
    return false;
  delete[] children;
  children = nullptr;
  return true;
}

LeafTree::Node* LeafTree::Tree::MakeRoot() {
  if (root == nullptr) {
    root = new Node();  // owned and deleted by the base class
    ++tree_size;
  }
  return root;
}

LeafTree::Node* LeafTree::Tree::GetOrMakeChild(Node* node, unsigned child) {
  if (nodeChildExists(node, child)) return getNodeChild(node, child);
  if (!node->HasArrayOfChildren()) ++num_arrays_;
  return createNodeChild(node, child);
}

void LeafTree::Tree::DeleteChild(Node* node, unsigned child) {
  deleteNodeChild(node, child);
  if (node->ReleaseEmptyChildren()) --num_arrays_;
}

std::int64_t LeafTree::Tree::memory_bytes() const {
  return static_cast<std::int64_t>(size() * sizeof(Node)) +
         num_arrays_ * static_cast<std::int64_t>(8 * sizeof(Node*));
}

LeafTree::LeafTree(const MappingConfig& config)
    : leaves_per_cell_(config.leaves_per_cell),
      cell_shift_(std::countr_zero(static_cast<unsigned>(config.leaves_per_cell))),
      cell_depth_(kDepth - static_cast<unsigned>(cell_shift_)),
      tree_(config.leaf_size_m) {
  TERRACE_CHECK(cell_depth_ >= kBlockDepth, config.leaves_per_cell);
}

std::int64_t LeafTree::memory_bytes() const {
  return tree_.memory_bytes() + leaves_.memory_bytes() + cells_.memory_bytes() + list_bytes_;
}

unsigned LeafTree::ChildIndex(const octomap::OcTreeKey& key, unsigned child_depth) {
  return static_cast<unsigned>(octomap::computeChildIdx(key, static_cast<int>(kDepth - child_depth)));
}

octomap::OcTreeKey LeafTree::KeyAt(const LeafIndex& index) {
  return {KeyOf(index.x()), KeyOf(index.y()), KeyOf(index.z())};
}

LeafTree::Corner LeafTree::CornerOfChild(const Corner& corner, unsigned child_depth, unsigned child) {
  const auto size = static_cast<std::int32_t>(1U << (kDepth - child_depth));
  return corner + size * Corner(child & 1U, (child >> 1U) & 1U, (child >> 2U) & 1U);
}

LeafIndex LeafTree::IndexNear(const Corner& corner, int size, const LeafIndex& near) {
  LeafIndex index;
  for (int i = 0; i < 3; ++i)
    index[i] = IndexOf(static_cast<std::uint16_t>(corner[i] + size / 2), near[i]) - size / 2;
  return index;
}

CellKey LeafTree::CellOf(const LeafIndex& index) const {
  return {index.x() >> cell_shift_, index.y() >> cell_shift_, index.z() >> cell_shift_};
}

LeafIndex LeafTree::CornerOf(const CellKey& key) const {
  return leaves_per_cell_ * LeafIndex(key.x, key.y, key.z);
}

int LeafTree::FindCell(const CellKey& key) const {
  const Node* node = tree_.search(KeyAt(CornerOf(key)), cell_depth_);
  // In an empty tree OctoMap finds the root, which is no cell.
  if (node == nullptr || node->getValue() == kNothing) return kNothing;
  // A cell far away may have the same keys.
  return cells_[node->getValue()].key == key ? node->getValue() : kNothing;
}

int LeafTree::CellAt(const CellKey& key) {
  if (last_cell_ != kNothing && last_cell_key_ == key) return last_cell_;
  const octomap::OcTreeKey octree_key = KeyAt(CornerOf(key));
  Node* node = tree_.MakeRoot();
  for (unsigned depth = 1; depth <= cell_depth_; ++depth)
    node = tree_.GetOrMakeChild(node, ChildIndex(octree_key, depth));
  if (node->getValue() == kNothing) {
    node->setValue(cells_.Take());
    cells_[node->getValue()].key = key;
  }
  TERRACE_CHECK(cells_[node->getValue()].key == key, "the octree holds places too far apart");
  last_cell_key_ = key;
  last_cell_ = node->getValue();
  return last_cell_;
}

bool LeafTree::IsStill(const FrameLeaf& seen, const CellKey& cell) const {
  if (seen.place.leaf == kNothing) return false;
  const Evidence& evidence = leaves_.evidence(seen.place.leaf);
  return evidence.cell == seen.place.cell && evidence.level == seen.address.level() &&
         evidence.corner == CornerInCell(seen.address, leaves_per_cell_) && evidence.alone &&
         cells_[evidence.cell].key == cell;
}

LeafPlace LeafTree::FindOrMake(const FrameLeaf& seen, const CellKey& cell, FrameId frame_id) {
  coarser_.clear();
  if (IsStill(seen, cell)) return seen.place;
  LeafPlace place{kNothing, CellAt(cell)};
  std::vector<int>& in_cell = cells_[place.cell].leaves;
  const Corner8 corner = CornerInCell(seen.address, leaves_per_cell_);
  const int level = seen.address.level();
  for (int above = level + 1; above <= CoarsestLevel(leaves_per_cell_); ++above) {
    Corner8 its_corner = corner;
    for (std::uint8_t& c : its_corner) c = static_cast<std::uint8_t>(c >> above << above);
    const int rank = Rank(its_corner, above);
    const auto at = FirstFrom(rank, leaves_, &in_cell);
    if (at == in_cell.end()) continue;
    Evidence& coarse = leaves_.evidence(*at);
    if (Rank(coarse.corner, coarse.level) != rank) continue;
    coarser_.push_back(*at);
    coarse.hit_frame = Evidence::FrameBits(frame_id);
  }
  const int rank = Rank(corner, level);
  const auto at = FirstFrom(rank, leaves_, &in_cell);
  if (at != in_cell.end()) {
    const Evidence& next = leaves_.evidence(*at);
    const int next_rank = Rank(next.corner, next.level);
    if (next_rank == rank) place.leaf = *at;
    // What lies in the leaf follows it at once: the place is known more finely.
    if (next_rank > rank && next_rank / kOrders < rank / kOrders + (1 << 3 * level)) return place;
  }
  if (place.leaf == kNothing) {
    place.leaf = leaves_.Take();
    Evidence& evidence = leaves_.evidence(place.leaf);
    evidence.corner = corner;
    evidence.level = static_cast<std::uint8_t>(level) & 31U;
    evidence.cell = place.cell;
    const std::size_t capacity = in_cell.capacity();
    in_cell.insert(at, place.leaf);
    list_bytes_ += static_cast<std::int64_t>((in_cell.capacity() - capacity) * sizeof(int));
  }
  leaves_.evidence(place.leaf).alone = coarser_.empty();
  return place;
}

void LeafTree::DropCoarser(Cell* cell) {
  for (const int coarse : coarser_) {
    std::erase(cell->leaves, coarse);
    leaves_.GiveBack(coarse);
    ++cell->num_changed_leaves;
  }
  coarser_.clear();
}

void LeafTree::DropUnoccupied(Cell* cell) {
  std::erase_if(cell->leaves, [&](int index) {
    if (leaves_.evidence(index).occupied) return false;
    leaves_.GiveBack(index);
    return true;
  });
  const std::size_t capacity = cell->leaves.capacity();
  cell->leaves.shrink_to_fit();
  list_bytes_ -= static_cast<std::int64_t>((capacity - cell->leaves.capacity()) * sizeof(int));
}

void LeafTree::GiveBackCell(int slot) {
  list_bytes_ -= static_cast<std::int64_t>(cells_[slot].leaves.capacity() * sizeof(int));
  cells_.GiveBack(slot);
  last_cell_ = kNothing;
}

void LeafTree::RemoveCell(const CellKey& key) {
  const octomap::OcTreeKey octree_key = KeyAt(CornerOf(key));
  Node* node = tree_.search(octree_key, cell_depth_);
  TERRACE_CHECK(node != nullptr && cells_[node->getValue()].leaves.empty());
  GiveBackCell(node->getValue());
  node->setValue(kNothing);
  DeleteEmptyPath(octree_key, cell_depth_);
}

void LeafTree::DeleteEmptyPath(const octomap::OcTreeKey& key, unsigned depth) {
  std::array<Node*, kDepth + 1> path{};
  path[0] = tree_.getRoot();
  for (unsigned d = 0; d < depth; ++d) path[d + 1] = tree_.getNodeChild(path[d], ChildIndex(key, d + 1));
  for (unsigned d = depth; d > 0; --d) {
    if (path[d]->getValue() != kNothing || path[d]->HasArrayOfChildren()) return;
    tree_.DeleteChild(path[d - 1], ChildIndex(key, d));
  }
}

std::vector<CellKey> LeafTree::ForgetBeyond(const LeafIndex& centre, int radius_leaves, int max_blocks) {
  // Distance, in finest leaves, from the centre to the nearest point of a node.
  const auto distance = [&](const LeafIndex& corner, int size) {
    const LeafIndex below = corner - centre, above = centre - corner - LeafIndex::Constant(size);
    return below.cwiseMax(above).cwiseMax(0).cast<double>().norm();
  };
  struct Block {
    Node* parent;
    unsigned child;
    Corner corner;
  };
  std::vector<Block> far;
  const auto find = [&](const auto& self, Node* node, unsigned depth, const Corner& corner) -> void {
    for (unsigned child = 0; child < 8; ++child) {
      if (!tree_.nodeChildExists(node, child)) continue;
      const Corner at = CornerOfChild(corner, depth + 1, child);
      if (depth + 1 < kBlockDepth) {
        self(self, tree_.getNodeChild(node, child), depth + 1, at);
        continue;
      }
      const int size = 1 << (kDepth - kBlockDepth);
      if (distance(IndexNear(at, size, centre), size) > radius_leaves) far.push_back({node, child, at});
    }
  };
  if (tree_.getRoot() != nullptr) find(find, tree_.getRoot(), 0, Corner::Zero());
  std::vector<CellKey> forgotten;
  for (int i = 0; i < std::min(max_blocks, static_cast<int>(far.size())); ++i) {
    const Block& block = far[static_cast<std::size_t>(i)];
    DeleteBelow(tree_.getNodeChild(block.parent, block.child), kBlockDepth, &forgotten);
    const octomap::OcTreeKey key(static_cast<octomap::key_type>(block.corner.x()),
                                 static_cast<octomap::key_type>(block.corner.y()),
                                 static_cast<octomap::key_type>(block.corner.z()));
    DeleteEmptyPath(key, kBlockDepth);
  }
  std::sort(forgotten.begin(), forgotten.end());
  return forgotten;
}

void LeafTree::DeleteBelow(Node* node, unsigned depth, std::vector<CellKey>* forgotten) {
  if (depth == cell_depth_) {
    Cell& gone = cells_[node->getValue()];
    forgotten->push_back(gone.key);
    for (const int leaf : gone.leaves) leaves_.GiveBack(leaf);
    GiveBackCell(node->getValue());
  }
  node->setValue(kNothing);
  for (unsigned child = 0; child < 8; ++child) {
    if (!tree_.nodeChildExists(node, child)) continue;
    DeleteBelow(tree_.getNodeChild(node, child), depth + 1, forgotten);
    tree_.DeleteChild(node, child);
  }
}

}  // namespace terrace
