// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <vector>

#include "core/time.h"
#include "mapping/leaf_tree.h"

namespace terrace {

/// Decides which cells are worth a new fit: those that changed a lot at once, small changes after a few
/// frames.
class ChangeReport {
 public:
  explicit ChangeReport(int memory_frames) : oldest_frames_(memory_frames / 4) {}

  /// Begins a frame.
  void Begin(FrameId frame_id);
  /// The frame has done something to this cell.
  void Touch(Cell* cell);
  /// The cell is gone.
  void Forget(const CellKey& key) { waiting_.erase(key); }

  /// The cells to be fitted now, ascending. One that has lost its last leaf is removed from the tree.
  std::vector<CellKey> Take(LeafTree* tree);

 private:
  bool IsWorthAFit(const Cell& cell) const;

  const FrameId oldest_frames_;
  FrameId frame_id_ = 0;
  std::vector<CellKey> touched_;  // by the frame at hand, each once
  std::set<CellKey> waiting_;
};

}  // namespace terrace
