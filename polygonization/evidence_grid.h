// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "core/rounding.h"
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
    std::uint16_t open = 0;  ///< a bit for each group that takes evidence, row by row
    FrameId on_frame = -1;   ///< the last frame that saw the surface here
    std::uint8_t num_looks = 0;
    bool contradicted = false;  ///< the last look found much that is not as it was
    /// Row by row; behind what says whether they need to be looked at.
    std::array<std::int8_t, kBlockCells * kBlockCells> cells{};

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

  double group_m() const { return cell_m_ * kGroupCells; }
  /// Takes evidence in boxes from now on. Boxes that follow each other mostly lie in one block or across two
  /// or four, which are looked up once.
  class Opener {
   public:
    explicit Opener(EvidenceGrid* grid) : grid_(*grid) {}
    /// The groups from low to high; their numbers are those of their first cells over kGroupCells.
    void OpenGroups(const Eigen::Vector2i& low, const Eigen::Vector2i& high);

   private:
    struct Known {
      Block* block = nullptr;
      BlockKey key{};
    };
    Block& BlockAt(const BlockKey& key);

    EvidenceGrid& grid_;
    std::array<Known, 4> known_;  // by the lowest bits of their keys
  };
  /// All groups that the box from low to high touches [m].
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

  int CellIndex(double coordinate_m) const { return FloorToInt(coordinate_m / cell_m_); }
  /// The block that a point lies in, and the cell there.
  std::pair<BlockKey, Eigen::Vector2i> Locate(const Eigen::Vector2d& p) const;
  /// Of the cell that holds a point; 0 where nothing is known.
  int At(const Eigen::Vector2d& p) const;

  /// Cells of a row from `x_begin` up to, but not with, `x_end` are known so well from now on.
  void Fill(int y, int x_begin, int x_end, std::int8_t known);
  /// Takes over what another grid knows where this one knows less.
  /// @param other_from_this  maps points of this grid's plane to those of the other's
  /// @return how many cells belong to the surface only since
  int Adopt(const EvidenceGrid& other, const Eigen::Affine2d& other_from_this);

  /// Answers as At() does, for points that mostly lie near each other, while the grid stays as it is.
  class Reader {
   public:
    explicit Reader(const EvidenceGrid& grid) : grid_(grid) {}
    int At(const Eigen::Vector2d& p) { return AtCell(grid_.CellIndex(p.x()), grid_.CellIndex(p.y())); }
    int AtCell(int x, int y) {
      const Block* block = BlockAt(x, y);
      return block == nullptr ? 0 : block->At(x & (kBlockCells - 1), y & (kBlockCells - 1));
    }
    /// Null where nothing is known.
    const Block* BlockAt(int x, int y) {
      const BlockKey key = KeyOf(x, y);
      if (!looked_up_ || key != key_) {
        const auto found = grid_.blocks_.find(key);
        block_ = found == grid_.blocks_.end() ? nullptr : &found->second;
        key_ = key;
        looked_up_ = true;
      }
      return block_;
    }

   private:
    const EvidenceGrid& grid_;
    const Block* block_ = nullptr;
    BlockKey key_{};  // of `block_`
    bool looked_up_ = false;
  };

  std::int64_t memory_bytes() const {
    // A node of the map holds three pointers and a colour beside its content.
    return static_cast<std::int64_t>(blocks_.size() * (sizeof(Blocks::value_type) + 4 * sizeof(void*)));
  }

 private:
  Block& MakeBlock(const BlockKey& key) {
    extent_.extend(Eigen::Vector2i(key.first, key.second));
    return blocks_[key];
  }
  /// Rounds towards minus infinity.
  static constexpr int BlockOf(int cell) { return cell >> kBlockShift; }
  static BlockKey KeyOf(int x, int y) { return {BlockOf(x), BlockOf(y)}; }

  static constexpr int kBlockShift = 4;
  static_assert(1 << kBlockShift == kBlockCells);
  static constexpr int kBlockGroups = kBlockCells / kGroupCells;  // along the edge of a block
  static constexpr int kGroupShift = 2;
  static_assert(1 << kGroupShift == kBlockGroups);

  double cell_m_;
  Blocks blocks_;
  Eigen::AlignedBox2i extent_;  // of the keys
};

}  // namespace terrace
