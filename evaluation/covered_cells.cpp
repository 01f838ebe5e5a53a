// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/covered_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {
namespace {

constexpr double kCoverDistance_m = 0.05;
constexpr double kCoverAngle_rad = 15.0 * EIGEN_PI / 180.0;

int NearestOver(const Eigen::Vector3d& centre, const std::vector<int>& candidates,
                const std::vector<MapRegion>& regions) {
  int nearest = kNoRegion;
  double least_m = std::numeric_limits<double>::infinity();
  for (int k : candidates) {
    const PlanarShape& shape = regions[static_cast<std::size_t>(k)].shape;
    const double distance_m = std::abs(shape.plane().SignedDistance(centre));
    if (distance_m > kCoverDistance_m || distance_m >= least_m || !shape.LiesOver(centre)) continue;
    nearest = k;
    least_m = distance_m;
  }
  return nearest;
}

}  // namespace

CoveredCells::CoveredCells(const PlanarShape& shape, const ObservedCells& cells,
                           const std::vector<MapRegion>& regions)
    : cells_(cells), shape_(shape), taken_(cells.seen.size(), kNotAsked) {
  std::vector<int> candidates;
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (regions[k].shape.AngleTo(shape_.plane()) <= kCoverAngle_rad) {
      candidates.push_back(static_cast<int>(k));
    }
  }
  for (int i = 0; i < cells_.nx; ++i) {
    for (int j = 0; j < cells_.ny; ++j) {
      const Eigen::Vector3d centre = cells_.Centre(i, j, shape_.plane());
      if (!cells_.seen[Index(i, j)] || !shape_.LiesOver(centre)) continue;
      taken_[Index(i, j)] = NearestOver(centre, candidates, regions);
    }
  }
}

int CoveredCells::TakenAt(const Eigen::Vector3d& p) const {
  const double i = std::floor((cells_.axis_x.dot(p) - cells_.origin_m.x()) / cells_.cell_m);
  const double j = std::floor((cells_.axis_y.dot(p) - cells_.origin_m.y()) / cells_.cell_m);
  if (!(i >= 0 && i < cells_.nx && j >= 0 && j < cells_.ny)) return kNotAsked;
  return taken_[Index(static_cast<int>(i), static_cast<int>(j))];
}

int CoveredCells::RegionAt(const Eigen::Vector3d& p) const { return std::max(TakenAt(p), kNoRegion); }

}  // namespace terrace
