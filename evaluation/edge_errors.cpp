// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/edge_errors.h"

#include <algorithm>
#include <cmath>

#include "evaluation/statistics.h"

namespace terrace {
namespace {

constexpr double kEdgeStep_m = 0.02;
/// Beyond this an edge is not displaced but absent.
constexpr double kMaxEdgeError_m = 0.2;

}  // namespace

void ForEachEdgeSample(
    const TrueShape& truth,
    const std::function<void(const Eigen::Vector3d& p, const Eigen::Vector3d& inwards)>& use) {
  const auto sample_ring = [&](const Ring& ring) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const Eigen::Vector3d edge = ring[i] - ring[j];
      const int steps = static_cast<int>(edge.norm() / kEdgeStep_m);
      if (steps == 0) continue;
      Eigen::Vector3d inwards = truth.shape.plane().normal.cross(edge).normalized();
      if (!truth.shape.LiesOver(ring[j] + 0.5 * edge + kEdgeStep_m * inwards)) inwards = -inwards;
      for (int step = 0; step < steps; ++step) use(ring[j] + (step + 0.5) / steps * edge, inwards);
    }
  };
  sample_ring(truth.polygon->outline_world);
  for (const Ring& hole : truth.polygon->holes_world) sample_ring(hole);
}

void EdgeErrors::Add(const TrueShape& truth, const CoveredCells& cells,
                     const std::vector<MapRegion>& regions) {
  ForEachEdgeSample(truth, [&](const Eigen::Vector3d& p, const Eigen::Vector3d& inwards) {
    const Eigen::Vector3d inside = p + kEdgeStep_m * inwards;
    if (!cells.Counts(inside)) return;
    const int k = cells.RegionAt(inside);
    if (k == kNoRegion) {
      distances_m_.push_back(kMaxEdgeError_m);
      return;
    }
    const PlanarShape& shape = regions[static_cast<std::size_t>(k)].shape;
    const double error_m = std::min(shape.DistanceToEdge(p), kMaxEdgeError_m);
    distances_m_.push_back(error_m);
    signed_m_.push_back(shape.LiesOver(p) ? error_m : -error_m);
  });
}

void EdgeErrors::Append(const EdgeErrors& other) {
  distances_m_.insert(distances_m_.end(), other.distances_m_.begin(), other.distances_m_.end());
  signed_m_.insert(signed_m_.end(), other.signed_m_.begin(), other.signed_m_.end());
}

EdgeFigures EdgeErrors::Figures() const {
  EdgeFigures figures;
  figures.count = static_cast<int>(distances_m_.size());
  if (distances_m_.empty()) return figures;
  figures.median_m = QuantileOf(distances_m_, 0.5);
  figures.p95_m = QuantileOf(distances_m_, 0.95);
  std::vector<double> covered_m = signed_m_;
  for (double& error_m : covered_m) error_m = std::abs(error_m);
  figures.covered_median_m = QuantileOf(covered_m, 0.5);
  figures.covered_p95_m = QuantileOf(covered_m, 0.95);
  figures.bias_m = MeanOf(signed_m_);
  figures.missed_share =
      1.0 - static_cast<double>(signed_m_.size()) / static_cast<double>(distances_m_.size());
  return figures;
}

}  // namespace terrace
