// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/change_report.h"

namespace terrace {
namespace {

constexpr float kWorthAFit = 1.2F;  // a fifth more weight
constexpr FrameId kPatience = 4;    // frames between two fits of a cell
constexpr int kManyLeaves = 12;     // that changed and make the next fit urgent

}  // namespace

void ChangeReport::Begin(FrameId frame_id) {
  frame_id_ = frame_id;
  touched_.clear();
}

void ChangeReport::Touch(Cell* cell) {
  if (cell->touched_frame == frame_id_) return;
  cell->touched_frame = frame_id_;
  touched_.push_back(cell->key);
}

bool ChangeReport::IsWorthAFit(const Cell& cell) const {
  const bool heavier = cell.weight > kWorthAFit * cell.fitted_weight;
  const bool old = frame_id_ - cell.reported_frame >= oldest_frames_;
  return cell.num_changed_leaves > 0 || heavier || old;
}

std::vector<CellKey> ChangeReport::Take(LeafTree* tree) {
  for (const CellKey& key : touched_)
    if (IsWorthAFit(tree->cell(tree->FindCell(key)))) waiting_.insert(key);
  std::vector<CellKey> now;
  for (auto at = waiting_.begin(); at != waiting_.end();) {
    Cell& cell = tree->cell(tree->FindCell(*at));
    if (frame_id_ - cell.reported_frame < kPatience && cell.num_changed_leaves < kManyLeaves) {
      ++at;
      continue;
    }
    cell.fitted_weight = cell.weight;
    cell.num_changed_leaves = 0;
    cell.reported_frame = frame_id_;
    now.push_back(*at);
    if (cell.leaves.empty()) tree->RemoveCell(*at);
    at = waiting_.erase(at);
  }
  return now;
}

}  // namespace terrace
