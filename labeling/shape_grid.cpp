// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/shape_grid.h"

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

void ShapeGrid::Add(const RegionShape& shape) {
  ForEachPlanCell(shape.bounds, [&](std::int64_t key) { cells_[key].push_back(shape.id()); });
}

void ShapeGrid::Remove(const RegionShape& shape) {
  ForEachPlanCell(shape.bounds, [&](std::int64_t key) {
    const auto cell = cells_.find(key);
    std::erase(cell->second, shape.id());
    if (cell->second.empty()) cells_.erase(cell);
  });
}

void ShapeGrid::Collect(const Eigen::AlignedBox3d& box, std::vector<PolygonId>* ids) const {
  ForEachPlanCell(box, [&](std::int64_t key) {
    const auto cell = cells_.find(key);
    if (cell != cells_.end()) ids->insert(ids->end(), cell->second.begin(), cell->second.end());
  });
}

}  // namespace terrace
