// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/plan_index.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

constexpr double kCell = 1.0;
/// A shape with more cells than this (100 m by 100 m) is cut off: a wrong polygon must not fill the memory.
constexpr std::int64_t kMaxCellsPerAxis = 100;

std::int64_t CellOf(double x) { return static_cast<std::int64_t>(std::floor(x / kCell)); }
std::int64_t KeyOf(std::int64_t x, std::int64_t y) { return (x << 32) + y; }

}  // namespace

PlanIndex::PlanIndex(const std::vector<RegionShapePtr>& shapes, double margin_m) {
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    const Eigen::AlignedBox3d& bounds = shapes[i]->bounds;
    const std::int64_t x0 = CellOf(bounds.min().x() - margin_m);
    const std::int64_t y0 = CellOf(bounds.min().y() - margin_m);
    const std::int64_t x1 = std::min(CellOf(bounds.max().x() + margin_m), x0 + kMaxCellsPerAxis);
    const std::int64_t y1 = std::min(CellOf(bounds.max().y() + margin_m), y0 + kMaxCellsPerAxis);
    for (std::int64_t x = x0; x <= x1; ++x)
      for (std::int64_t y = y0; y <= y1; ++y) cells_.emplace_back(KeyOf(x, y), i);
  }
  std::sort(cells_.begin(), cells_.end());
}

std::vector<int> PlanIndex::Near(const Eigen::Vector2d& p) const {
  const std::int64_t key = KeyOf(CellOf(p.x()), CellOf(p.y()));
  std::vector<int> found;
  for (auto it = std::lower_bound(cells_.begin(), cells_.end(), std::pair<std::int64_t, int>(key, 0));
       it != cells_.end() && it->first == key; ++it)
    found.push_back(it->second);
  return found;
}

}  // namespace terrace
