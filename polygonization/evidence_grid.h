// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "core/time.h"

namespace terrace {

/// What pixels have shown of one plane, in square cells of it. A cell's number is positive where pixels lay
/// on the plane, negative where they saw through it, zero where nothing is known; how far from zero tells how
/// often and how finely. Cells come in blocks, and only where there is something to be kept: one byte a cell.
class EvidenceGrid {
 public:
  static constexpr int kBlockCells = 16;  ///< along the edge of a block
  static constexpr int kOn = 2;           ///< from here on a cell belongs to the surface
  static constexpr int kThrough = -4;     ///< from here on down it does not
  static constexpr int kGroupCells = 4;   ///< along the edge of a group, in which evidence is taken or not

  /// x and y of a block.
  using BlockKey = std::pair<int, int>;
  struct Block {
    std::array<std::int8_t, kBlockCells * kBlockCells> cells{};  ///< row by row
    std::uint16_t open = 0;  ///< a bit for each group that takes evidence, row by row
    FrameId on_frame = -1;   ///< the last frame that saw the surface here
    std::uint8_t num_looks = 0;
    bool contradicted = false;  ///< the last look found much that is not as it was

    bool IsOpen(int x, int y) const {
      return (open >> (y / kGroupCells * (kBlockCells / kGroupCells) + x / kGroupCells) & 1) != 0;
    }
    void OpenGroup(int x, int y) {
      open = static_cast<std::uint16_t>(
          open | 1U << (y / kGroupCells * (kBlockCells / kGroupCells) + x / kGroupCells));
    }
    std::int8_t& At(int x, int y) { return cells[static_cast<std::size_t>(y * kBlockCells + x)]; }
    std::int8_t At(int x, int y) const { return cells[static_cast<std::size_t>(y * kBlockCells + x)]; }
  };
  using Blocks = std::map<BlockKey, Block>;

  explicit EvidenceGrid(double cell_m = 0.01) : cell_m_(cell_m) {}

  double cell_m() const { return cell_m_; }
  double block_m() const { return cell_m_ * kBlockCells; }
  Blocks& blocks() { return blocks_; }
  const Blocks& blocks() const { return blocks_; }

  /// Takes evidence in the box from low to high from now on.
  void Open(const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  /// Takes evidence nowhere until it is opened again; what is known stays.
  void Close() {
    for (auto& [key, block] : blocks_) block.open = 0;
  }
  /// Box around all blocks [m]; empty when there is none.
  Eigen::AlignedBox2d extent() const {
    if (extent_.isEmpty()) return {};
    return {block_m() * extent_.min().cast<double>(),
            block_m() * (extent_.max() + Eigen::Vector2i::Ones()).cast<double>()};
  }

  int CellIndex(double coordinate_m) const;
  /// The block that a point lies in, and the cell there.
  std::pair<BlockKey, Eigen::Vector2i> Locate(const Eigen::Vector2d& p) const;
  /// Of the cell that holds a point; 0 where nothing is known.
  int At(const Eigen::Vector2d& p) const;

  /// Takes over what another grid knows where this one knows less; `to_other` maps points of this grid's
  /// plane to the other's, and `from_other` back.
  template <typename ToOther, typename FromOther>
  void Adopt(const EvidenceGrid& other, const ToOther& to_other, const FromOther& from_other);

  std::int64_t memory_bytes() const {
    // A node of the map holds three pointers and a colour beside its content.
    return static_cast<std::int64_t>(blocks_.size() * (sizeof(Blocks::value_type) + 4 * sizeof(void*)));
  }

 private:
  Block& MakeBlock(const BlockKey& key) {
    extent_.extend(Eigen::Vector2i(key.first, key.second));
    return blocks_[key];
  }
  static BlockKey KeyOf(int x, int y);

  double cell_m_;
  Blocks blocks_;
  Eigen::AlignedBox2i extent_;  // of the keys
};

template <typename ToOther, typename FromOther>
void EvidenceGrid::Adopt(const EvidenceGrid& other, const ToOther& to_other, const FromOther& from_other) {
  std::map<BlockKey, bool> covered;
  for (const auto& [key, block] : other.blocks_) {
    if (block.num_looks == 0) continue;
    const Eigen::Vector2d corner = other.block_m() * Eigen::Vector2d(key.first, key.second);
    for (const double dx : {0.0, 1.0}) {
      for (const double dy : {0.0, 1.0}) {
        const Eigen::Vector2d p = from_other(corner + other.block_m() * Eigen::Vector2d(dx, dy));
        covered[KeyOf(CellIndex(p.x()), CellIndex(p.y()))] = true;
      }
    }
    const Eigen::Vector2d middle = from_other(corner + 0.5 * other.block_m() * Eigen::Vector2d::Ones());
    covered[KeyOf(CellIndex(middle.x()), CellIndex(middle.y()))] = true;
  }
  const Block* their_block = nullptr;
  BlockKey last_key{std::numeric_limits<int>::min(), 0};
  for (const auto& [key, unused] : covered) {
    Block& block = MakeBlock(key);
    for (int y = 0; y < kBlockCells; ++y) {
      for (int x = 0; x < kBlockCells; ++x) {
        const Eigen::Vector2d p =
            cell_m_ * Eigen::Vector2d(key.first * kBlockCells + x + 0.5, key.second * kBlockCells + y + 0.5);
        const Eigen::Vector2d q = to_other(p);
        const int i = other.CellIndex(q.x()), j = other.CellIndex(q.y());
        const BlockKey their_key = KeyOf(i, j);
        if (their_key != last_key) {
          last_key = their_key;
          const auto found = other.blocks_.find(their_key);
          their_block = found == other.blocks_.end() ? nullptr : &found->second;
        }
        if (their_block == nullptr) continue;
        const int bx = i - their_key.first * kBlockCells, by = j - their_key.second * kBlockCells;
        const int theirs = their_block->At(bx, by);
        if (their_block->IsOpen(bx, by)) block.OpenGroup(x, y);
        std::int8_t& ours = block.At(x, y);
        if (std::abs(theirs) > std::abs(ours)) ours = static_cast<std::int8_t>(theirs);
      }
    }
  }
}

}  // namespace terrace
