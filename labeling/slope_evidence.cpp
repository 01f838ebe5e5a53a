// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/slope_evidence.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"

namespace terrace {

double LowestStepThatShows(const RegionShape& shape) {
  constexpr double kSigmas = 3.0;
  return 2.0 * kSigmas * shape.polygon->noise_m / std::max(0.1, std::cos(shape.slope_rad));
}

bool SteepAsStairs(const RegionShape& shape, const StaircaseConfig& stairs) {
  const double flattest = std::atan2(stairs.min_riser_m, stairs.max_tread_m);
  return shape.slope_rad >= flattest && shape.slope_rad <= Radians(stairs.max_pitch_deg);
}

bool CouldBeStairs(const RegionShape& shape, const StaircaseConfig& stairs) {
  return SteepAsStairs(shape, stairs) && shape.heights().length() >= stairs.min_riser_m;
}

bool DepartsFromPlane(const RegionShape& shape, const StaircaseConfig& stairs) {
  // Steps of height h leave h cos(slope) / sqrt(12) rms; a quarter of that when matching has rounded them, or
  // when little more than one of them is in the piece.
  const double least_steps_m = 0.25 * stairs.min_riser_m * std::cos(shape.slope_rad) / std::sqrt(12.0);
  // Leaves hold the mean of many points, so that on a plane they scatter less than points do. Where noise
  // could hide the lowest steps it is not trusted to be known that well.
  const bool resolved = LowestStepThatShows(shape) <= stairs.min_riser_m;
  const double share_of_noise = resolved ? 0.75 : 1.0;
  return shape.polygon->rms_m > std::max(share_of_noise * shape.polygon->noise_m, least_steps_m);
}

SlopeEvidence JudgeSlope(const RegionShape& shape, const StaircaseConfig& stairs) {
  if (LowestStepThatShows(shape) > stairs.min_riser_m) return SlopeEvidence::kNotResolved;
  return DepartsFromPlane(shape, stairs) ? SlopeEvidence::kNotPlane : SlopeEvidence::kPlane;
}

}  // namespace terrace
