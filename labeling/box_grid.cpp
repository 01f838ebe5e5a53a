// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/box_grid.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

constexpr double kCellEdge = 4.0;

/// Calls visit(key) for each cell of the plan that the box meets.
template <typename Visit>
void ForEachPlanCell(const Eigen::AlignedBox3d& box, const Visit& visit) {
  const auto index = [](double x) { return static_cast<std::int64_t>(std::floor(x / kCellEdge)); };
  for (std::int64_t x = index(box.min().x()); x <= index(box.max().x()); ++x)
    for (std::int64_t y = index(box.min().y()); y <= index(box.max().y()); ++y)
      visit(x * (std::int64_t{1} << 32) + y);
}

}  // namespace

void BoxGrid::Add(PolygonId id, const Eigen::AlignedBox3d& box) {
  ForEachPlanCell(box, [&](std::int64_t key) { cells_[key].push_back(id); });
}

void BoxGrid::Remove(PolygonId id, const Eigen::AlignedBox3d& box) {
  ForEachPlanCell(box, [&](std::int64_t key) {
    const auto cell = cells_.find(key);
    std::erase(cell->second, id);
    if (cell->second.empty()) cells_.erase(cell);
  });
}

void BoxGrid::Collect(const Eigen::AlignedBox3d& box, std::vector<PolygonId>* ids) const {
  ForEachPlanCell(box, [&](std::int64_t key) {
    const auto cell = cells_.find(key);
    if (cell != cells_.end()) ids->insert(ids->end(), cell->second.begin(), cell->second.end());
  });
}

}  // namespace terrace
