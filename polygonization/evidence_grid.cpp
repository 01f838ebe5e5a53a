// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/evidence_grid.h"

#include <limits>
#include <utility>

namespace terrace {
namespace {

/// Rounds towards minus infinity.
int BlockOf(int cell) {
  constexpr int n = EvidenceGrid::kBlockCells;
  return (cell >= 0 ? cell : cell - n + 1) / n;
}

}  // namespace

EvidenceGrid::BlockKey EvidenceGrid::KeyOf(int x, int y) { return {BlockOf(x), BlockOf(y)}; }

int EvidenceGrid::CellIndex(double coordinate_m) const {
  const double cells = coordinate_m / cell_m_;
  const int towards_zero = static_cast<int>(cells);
  return towards_zero - static_cast<int>(static_cast<double>(towards_zero) > cells);
}

void EvidenceGrid::Open(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const int x1 = CellIndex(high.x()), y1 = CellIndex(high.y());
  // From the first cell of the first group on.
  const auto first = [](int cell) { return cell - (cell % kGroupCells + kGroupCells) % kGroupCells; };
  Block* block = nullptr;
  BlockKey last{std::numeric_limits<int>::min(), 0};
  for (int y = first(CellIndex(low.y())); y <= y1; y += kGroupCells) {
    for (int x = first(CellIndex(low.x())); x <= x1; x += kGroupCells) {
      const BlockKey key = KeyOf(x, y);
      if (key != last) block = &MakeBlock(key);
      last = key;
      block->OpenGroup(x - key.first * kBlockCells, y - key.second * kBlockCells);
    }
  }
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

}  // namespace terrace
