// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "labeling/region_shape.h"

namespace terrace {

/// Finds the shapes about a place of the plan without looking at all of them.
class PlanIndex {
 public:
  /// @param margin_m  a shape is found from everywhere within this distance of its bounds
  PlanIndex(const std::vector<RegionShapePtr>& shapes, double margin_m);

  /// Indices, ascending, of the shapes whose bounds may lie within the margin of p.
  std::vector<int> Near(const Eigen::Vector2d& p) const;

 private:
  std::vector<std::pair<std::int64_t, int>> cells_;  ///< cell, index of a shape; ascending
};

}  // namespace terrace
