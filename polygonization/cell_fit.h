// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "polygonization/cell_modeller.h"
#include "polygonization/plane_support.h"

namespace terrace {

/// Fits the planes of one cell, one after the other, each to what the ones before left over: RMSAC
/// hypotheses through three leaves and the planes that are known already, then least squares.
class CellFit {
 public:
  /// @param surfels  of the cell; kept by reference
  /// @param hints    planes that may pass through the cell
  /// @param seed     of the hypotheses
  CellFit(const ModellingConfig& config, const std::vector<Surfel>& surfels, double cell_size_m,
          std::vector<CellPlane> hints, std::uint64_t seed);

  /// Patches relative to the centre of the cell.
  std::vector<Patch> Run();

 private:
  /// Where a leaf lies as a plane sees it.
  struct Place {
    float facing;  ///< cosine between the normal and the way to the camera
    float
        cost;  ///< squared distance of the mean, in units of what is allowed; 1 where it is none of the plane
  };
  Place PlaceOf(const Surfel& s, const CellPlane& plane) const;
  /// Whether the points of a leaf lie along a plane that its mean is near.
  bool Belongs(const Surfel& s, const Place& place, const CellPlane& plane) const;

  std::optional<CellPlane> Through(int a, int b, int c) const;
  std::optional<CellPlane> BestHypothesis(const std::vector<int>& rest);
  /// Weighted least squares; Tukey's weight lets go of what lies near the limit.
  std::optional<CellPlane> Refit(const std::vector<int>& rest, const CellPlane& plane,
                                 PlaneMoments* moments) const;
  Patch MakePatch(const CellPlane& plane, const PlaneMoments& moments, const std::vector<int>& inliers) const;
  /// Root mean square of the distances, as a share of what is allowed.
  float RmsShare(const std::vector<int>& inliers, const CellPlane& plane) const;
  const Surfel& surfel(int i) const { return surfels_[static_cast<std::size_t>(i)]; }
  int AnyOf(int count);

  const ModellingConfig& config_;
  const std::vector<Surfel>& surfels_;
  const InlierLimits limits_;
  const std::vector<CellPlane> hints_;
  std::uint64_t random_state_;
  SurfelColumns sample_columns_, rest_columns_;
};

}  // namespace terrace
