// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/evidence_grid.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <utility>

namespace terrace {

EvidenceGrid::Block& EvidenceGrid::Opener::BlockAt(const BlockKey& key) {
  Known& known = known_[static_cast<std::size_t>((key.first & 1) + 2 * (key.second & 1))];
  if (known.block == nullptr || known.key != key) known = {&grid_.MakeBlock(key), key};
  return *known.block;
}

void EvidenceGrid::Opener::OpenGroups(const Eigen::Vector2i& low, const Eigen::Vector2i& high) {
  for (int y = low.y(); y <= high.y(); ++y)
    for (int x = low.x(); x <= high.x(); ++x)
      BlockAt({x >> kGroupShift, y >> kGroupShift})
          .OpenGroup((x & (kBlockGroups - 1)) * kGroupCells, (y & (kBlockGroups - 1)) * kGroupCells);
}

void EvidenceGrid::Open(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const auto group_at = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2i(FloorToInt(p.x() / group_m()), FloorToInt(p.y() / group_m()));
  };
  Opener(this).OpenGroups(group_at(low), group_at(high));
}

std::pair<EvidenceGrid::BlockKey, Eigen::Vector2i> EvidenceGrid::Locate(const Eigen::Vector2d& p) const {
  const int x = CellIndex(p.x()), y = CellIndex(p.y());
  const BlockKey key = KeyOf(x, y);
  return {key, {x - key.first * kBlockCells, y - key.second * kBlockCells}};
}

int EvidenceGrid::At(const Eigen::Vector2d& p) const {
  const auto [key, cell] = Locate(p);
  const auto found = blocks_.find(key);
  return found == blocks_.end() ? 0 : found->second.At(cell.x(), cell.y());
}

void EvidenceGrid::Fill(int y, int x_begin, int x_end, std::int8_t known) {
  for (int x = x_begin; x < x_end;) {
    const BlockKey key = KeyOf(x, y);
    const int block_end = std::min(x_end, (key.first + 1) * kBlockCells);
    Block& block = MakeBlock(key);
    block.num_looks = std::max<std::uint8_t>(block.num_looks, 1);
    for (; x < block_end; ++x) block.At(x - key.first * kBlockCells, y - key.second * kBlockCells) = known;
  }
}

int EvidenceGrid::Adopt(const EvidenceGrid& other, const Eigen::Affine2d& other_from_this) {
  const Eigen::Affine2d this_from_other = other_from_this.inverse();
  std::set<BlockKey> covered;
  for (const auto& [key, block] : other.blocks_) {
    if (block.num_looks == 0) continue;
    const Eigen::Vector2d corner = other.block_m() * Eigen::Vector2d(key.first, key.second);
    for (const Eigen::Vector2d& share :
         {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0),
          Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(0.5, 0.5)}) {
      const Eigen::Vector2d p = this_from_other * (corner + other.block_m() * share);
      covered.insert(KeyOf(CellIndex(p.x()), CellIndex(p.y())));
    }
  }
  // One cell of this grid on, in cells of the other.
  const Eigen::Matrix2d step = other_from_this.linear() * (cell_m_ / other.cell_m_);
  Reader theirs(other);
  int num_on = 0;
  for (const BlockKey& key : covered) {
    Block* block = nullptr;  // made where there is something to be taken over
    const auto ours_there = [&]() -> Block& { return block ? *block : *(block = &MakeBlock(key)); };
    const Eigen::Vector2d first(key.first * kBlockCells + 0.5, key.second * kBlockCells + 0.5);
    const Eigen::Vector2d row_start = other_from_this * (cell_m_ * first) / other.cell_m_;
    for (int y = 0; y < kBlockCells; ++y) {
      for (int x = 0; x < kBlockCells; ++x) {
        const Eigen::Vector2d q = row_start + x * step.col(0) + y * step.col(1);
        const int i = FloorToInt(q.x()), j = FloorToInt(q.y());
        const Block* their_block = theirs.BlockAt(i, j);
        if (their_block == nullptr) continue;
        const int bx = i & (kBlockCells - 1), by = j & (kBlockCells - 1);
        if (their_block->IsOpen(bx, by)) ours_there().OpenGroup(x, y);
        const std::int8_t known = their_block->At(bx, by);
        if (known == 0) continue;
        std::int8_t& ours = ours_there().At(x, y);
        if (std::abs(known) <= std::abs(ours)) continue;
        num_on += ours < kOn && known >= kOn;
        ours = known;
      }
    }
  }
  return num_on;
}

}  // namespace terrace
