// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include "labeling/region_shape.h"

namespace terrace {

/// Finds the shapes about a place of a map that changes, without looking at all of them.
class ShapeGrid {
 public:
  void Add(const RegionShape& shape);
  /// With the bounds that it was added with.
  void Remove(const RegionShape& shape);
  void Clear() { cells_.clear(); }
  /// Appends the ids of all shapes whose bounds may meet the box in the plan, in no order; some more than
  /// once.
  void Collect(const Eigen::AlignedBox3d& box, std::vector<PolygonId>* ids) const;

 private:
  std::unordered_map<std::int64_t, std::vector<PolygonId>> cells_;
};

}  // namespace terrace
