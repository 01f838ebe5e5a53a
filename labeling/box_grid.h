// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include "polygonization/polygon.h"

namespace terrace {

/// Finds the regions about a place of a map that changes, without looking at all of them, by boxes around
/// them.
class BoxGrid {
 public:
  void Add(PolygonId id, const Eigen::AlignedBox3d& box);
  /// @param box  with which it was added
  void Remove(PolygonId id, const Eigen::AlignedBox3d& box);
  /// Appends the ids of all whose boxes may meet this one in the plan, in no order; some more than once.
  void Collect(const Eigen::AlignedBox3d& box, std::vector<PolygonId>* ids) const;

 private:
  std::unordered_map<std::int64_t, std::vector<PolygonId>> cells_;
};

}  // namespace terrace
