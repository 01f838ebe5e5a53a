// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "evaluation/covered_cells.h"
#include "evaluation/map_shapes.h"

namespace terrace {

/// Calls use(p, inwards) every 2 cm along the rings of a polygon: a point of the edge, and the unit vector in
/// the plane, across the edge, to the side where the polygon is.
void ForEachEdgeSample(
    const TrueShape& truth,
    const std::function<void(const Eigen::Vector3d& p, const Eigen::Vector3d& inwards)>& use);

/// How far the edges of regions are from the true ones, over samples of the true edges.
struct EdgeFigures {
  int count = 0;
  double median_m = 0.0;          ///< of all samples; one that no region covers is 20 cm off
  double p95_m = 0.0;             ///< of all samples
  double covered_median_m = 0.0;  ///< of those that are covered
  double covered_p95_m = 0.0;
  double bias_m = 0.0;        ///< mean of those that are covered: positive where regions reach too far
  double missed_share = 0.0;  ///< of the samples, that no region covers
};

/// Collects them.
class EdgeErrors {
 public:
  /// Samples the true edges where the cell 2 cm inside counts, and asks how far the nearest edge of the
  /// region is that covers this cell, in its plane, at most 20 cm.
  void Add(const TrueShape& truth, const CoveredCells& cells, const std::vector<MapRegion>& regions);
  void Append(const EdgeErrors& other);
  EdgeFigures Figures() const;

 private:
  std::vector<double> distances_m_;  ///< of all samples
  std::vector<double> signed_m_;     ///< of those that are covered
};

}  // namespace terrace
