// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "datasets/ground_truth.h"
#include "evaluation/map_shapes.h"

namespace terrace {

inline constexpr int kNoRegion = -1;

/// Which region covers each cell of one true polygon: the nearest of those over which its centre lies, within
/// 5 cm and 15 deg. Cells whose centre is outside the rings do not count.
class CoveredCells {
 public:
  /// @param cells  of the polygon, those that count marked; kept by reference, as the shape
  CoveredCells(const PlanarShape& shape, const ObservedCells& cells, const std::vector<MapRegion>& regions);

  /// Calls use(centre, region index or kNoRegion) for every cell that counts.
  template <typename Use>
  void ForEach(Use use) const {
    for (int i = 0; i < cells_.nx; ++i) {
      for (int j = 0; j < cells_.ny; ++j) {
        const int region = taken_[Index(i, j)];
        if (region != kNotAsked) use(cells_.Centre(i, j, shape_.plane()), region);
      }
    }
  }

  /// Does the cell that holds this point of the plane count?
  bool Counts(const Eigen::Vector3d& p) const { return TakenAt(p) != kNotAsked; }
  /// The region over the cell that holds this point of the plane; kNoRegion when there is none or the cell
  /// does not count.
  int RegionAt(const Eigen::Vector3d& p) const;

 private:
  static constexpr int kNotAsked = -2;

  std::size_t Index(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(cells_.ny) + static_cast<std::size_t>(j);
  }
  int TakenAt(const Eigen::Vector3d& p) const;

  const ObservedCells& cells_;
  const PlanarShape& shape_;
  std::vector<int> taken_;
};

}  // namespace terrace
