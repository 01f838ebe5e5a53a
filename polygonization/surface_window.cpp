// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_window.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terrace {
namespace {

constexpr int kBlockShift = 2;  // four cells along the edge of a block
constexpr int kBlockCells = 1 << kBlockShift;
/// A surface leaves the window only this far beyond it, so that none comes and goes with every step.
constexpr double kMargin_m = 2.0;
/// A node of a map or set, beside its content.
constexpr std::size_t kNodeBytes = 4 * sizeof(void*);
constexpr std::size_t kBytesPerBlock = kNodeBytes + sizeof(CellKey) + sizeof(std::set<SurfaceId>);
constexpr std::size_t kBytesPerEntry = kNodeBytes + sizeof(SurfaceId);

CellKey BlockOf(const CellKey& cell) {
  return {cell.x >> kBlockShift, cell.y >> kBlockShift, cell.z >> kBlockShift};
}

template <typename Cells, typename KeyOf>
std::set<CellKey> BlocksOf(const Cells& cells, const KeyOf& key_of) {
  std::set<CellKey> blocks;
  for (const auto& cell : cells) blocks.insert(BlockOf(key_of(cell)));
  return blocks;
}

std::set<CellKey> BlocksOf(const Surface& surface) {
  return BlocksOf(surface.cells, [](const CellKey& key) { return key; });
}

std::set<CellKey> BlocksOf(const FarSurface& far) {
  return BlocksOf(far.parts, [](const FarSurface::Part& part) { return part.cell; });
}

bool HaveOneInCommon(const std::set<CellKey>& few, const std::set<CellKey>& many) {
  return std::any_of(few.begin(), few.end(), [&](const CellKey& block) { return many.contains(block); });
}

}  // namespace

CellKey SurfaceWindow::BlockAt(const Eigen::Vector3d& p_world) const {
  const Eigen::Vector3i block = (p_world / (kBlockCells * reach_.cell_size_m)).array().floor().cast<int>();
  return {block.x(), block.y(), block.z()};
}

double SurfaceWindow::Distance(const CellKey& block) const {
  const Eigen::Array3i apart(block.x - block_->x, block.y - block_->y, block.z - block_->z);
  const Eigen::Array3i between = (apart.abs() - 1).max(0);
  return kBlockCells * reach_.cell_size_m * between.matrix().cast<double>().norm();
}

bool SurfaceWindow::Within(const Blocks& blocks, double distance_m) const {
  return std::any_of(blocks.begin(), blocks.end(),
                     [&](const CellKey& block) { return Distance(block) <= distance_m; });
}

/// Adds all that touch blocks and may lie beyond a distance.
void SurfaceWindow::AddAround(const Blocks& blocks, double distance_m, Blocks* around) const {
  const double diagonal_m = std::sqrt(3.0) * kBlockCells * reach_.cell_size_m;
  for (const CellKey& b : blocks) {
    if (Distance(b) + diagonal_m <= distance_m) continue;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz) around->insert({b.x + dx, b.y + dy, b.z + dz});
  }
}

std::set<SurfaceId> SurfaceWindow::FarOnesIn(const Blocks& blocks) const {
  std::set<SurfaceId> ids;
  if (far_by_block_.empty()) return ids;
  for (const CellKey& block : blocks)
    if (const auto found = far_by_block_.find(block); found != far_by_block_.end())
      ids.insert(found->second.begin(), found->second.end());
  return ids;
}

/// Asks column by column, so that it costs the same however large the map is.
std::set<SurfaceId> SurfaceWindow::FarOnesWithin(double distance_m) const {
  std::set<SurfaceId> ids;
  const int reach = static_cast<int>(std::ceil(distance_m / (kBlockCells * reach_.cell_size_m))) + 1;
  for (int x = block_->x - reach; x <= block_->x + reach; ++x) {
    for (int y = block_->y - reach; y <= block_->y + reach; ++y) {
      const auto end = far_by_block_.upper_bound({x, y, block_->z + reach});
      for (auto at = far_by_block_.lower_bound({x, y, block_->z - reach}); at != end; ++at)
        if (Distance(at->first) <= distance_m) ids.insert(at->second.begin(), at->second.end());
    }
  }
  return ids;
}

std::vector<PolygonId> SurfaceWindow::Move(const Eigen::Vector3d& p_world, const std::set<SurfaceId>& waiting,
                                           const PolygonMap& polygons, SurfaceStore* store) {
  if (!std::isfinite(reach_.window_m)) return {};
  const CellKey block = BlockAt(p_world);
  if (block_ == block) return {};
  block_ = block;
  store->touched().clear();
  if (!far_.empty()) BringBackNear(polygons, store);
  TakeAwayFar(waiting, store);
  return ForgetBeyond();
}

void SurfaceWindow::BringBackNear(const PolygonMap& polygons, SurfaceStore* store) {
  const auto bring_back = [&](const std::set<SurfaceId>& ids) {
    for (const SurfaceId id : ids) BringBack(id, Take(id), polygons, reach_.cell_size_m, store);
  };
  bring_back(FarOnesWithin(reach_.window_m));
  Blocks around;
  for (const auto& [id, surface] : store->surfaces()) {
    const Blocks blocks = BlocksOf(surface);
    if (Within(blocks, reach_.window_m)) AddAround(blocks, reach_.window_m, &around);
  }
  bring_back(FarOnesIn(around));
  store->RefitTouched();
}

void SurfaceWindow::TakeAwayFar(const std::set<SurfaceId>& waiting, SurfaceStore* store) {
  const double window_m = reach_.window_m + kMargin_m;
  Blocks around;
  std::map<SurfaceId, Blocks> outside;
  for (const auto& [id, surface] : store->surfaces()) {
    Blocks blocks = BlocksOf(surface);
    if (Within(blocks, window_m))
      AddAround(blocks, window_m, &around);
    else if (!waiting.contains(id))
      outside.emplace(id, std::move(blocks));
  }
  for (const auto& [id, blocks] : outside) {
    if (HaveOneInCommon(blocks, around)) continue;
    // What is not published is not worth keeping: it is found again.
    if (!store->surfaces().at(id).polygons.empty()) Put(id, blocks, Remember(id, *store));
    store->Remove(id);
  }
}

std::vector<PolygonId> SurfaceWindow::ForgetBeyond() {
  std::vector<PolygonId> forgotten;
  if (!std::isfinite(reach_.keep_beyond_m)) return forgotten;
  std::set<SurfaceId> kept;
  for (const auto& [block, ids] : far_by_block_)
    if (Distance(block) <= reach_.keep_beyond_m) kept.insert(ids.begin(), ids.end());
  std::vector<SurfaceId> gone;
  for (const auto& [id, far] : far_)
    if (!kept.contains(id)) gone.push_back(id);
  for (const SurfaceId id : gone) {
    const FarSurface far = Take(id);
    forgotten.insert(forgotten.end(), far.polygons.begin(), far.polygons.end());
  }
  std::sort(forgotten.begin(), forgotten.end());
  return forgotten;
}

void SurfaceWindow::Put(SurfaceId id, const Blocks& blocks, FarSurface far) {
  bytes_ += far.memory_bytes() + static_cast<std::int64_t>(kBytesPerEntry + blocks.size() * kBytesPerEntry);
  for (const CellKey& block : blocks) {
    std::set<SurfaceId>& ids = far_by_block_[block];
    if (ids.empty()) bytes_ += static_cast<std::int64_t>(kBytesPerBlock);
    ids.insert(id);
  }
  far_.emplace(id, std::move(far));
}

FarSurface SurfaceWindow::Take(SurfaceId id) {
  FarSurface far = std::move(far_.at(id));
  far_.erase(id);
  const Blocks blocks = BlocksOf(far);
  bytes_ -= far.memory_bytes() + static_cast<std::int64_t>(kBytesPerEntry + blocks.size() * kBytesPerEntry);
  for (const CellKey& block : blocks) {
    const auto ids = far_by_block_.find(block);
    ids->second.erase(id);
    if (!ids->second.empty()) continue;
    far_by_block_.erase(ids);
    bytes_ -= static_cast<std::int64_t>(kBytesPerBlock);
  }
  return far;
}

}  // namespace terrace
