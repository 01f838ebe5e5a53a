// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/stride.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/angles.h"

namespace terrace {

bool Stride::Plausible(const StaircaseConfig& config) const {
  if (rise < config.min_riser_m || rise > config.max_riser_m) return false;
  if (run < config.min_tread_m || run > config.max_tread_m) return false;
  const double pitch = std::atan2(rise, run);
  return pitch >= Radians(config.min_pitch_deg) && pitch <= Radians(config.max_pitch_deg);
}

std::optional<StepFit> FitStep(const StaircaseConfig& config, const FlightFrame& frame, const Stride& stride,
                               const StepElement& e) {
  if (stride.rise < e.min_rise_m) return std::nullopt;
  const double beside = e.lateral.Overlap(stride.lateral);
  if (beside < 0.4 * std::min(e.lateral.length(), stride.lateral.length())) return std::nullopt;
  // Heights are better than depths: they choose the step.
  const double steps_up = (e.z - stride.z0) / stride.rise;
  const int k = static_cast<int>(std::lround(e.riser ? steps_up + 0.5 : steps_up));
  const double edge = stride.along0 + (k - 1) * stride.run;
  const double z_low = stride.z0 + (k - 1) * stride.rise;
  const double z_high = z_low + stride.rise;
  const double shift = frame.Unwrapped(e.along.low, edge) - e.along.low;
  const double low = e.along.low + shift;
  const double high = e.along.high + shift;
  const double height_tolerance = config.HeightTolerance(stride.rise);
  double strain = 0.0;  // of the worst measure, in tolerances
  if (e.riser) {
    strain = std::abs(low - edge) / config.edge_tolerance_m;
    // Rounded edges and strips of the neighbours: twice the tolerance at the ends of a face.
    const double beyond = std::max(z_low - e.heights.low, e.heights.high - z_high);
    strain = std::max(strain, 0.5 * beyond / height_tolerance);
  } else if (e.underside || e.landing) {
    // From below the front of a board is in view, whatever is seen of its back, and from above that of a
    // landing.
    strain =
        std::max(std::abs(e.z - z_high) / height_tolerance, std::abs(low - edge) / config.edge_tolerance_m);
  } else {
    strain = std::abs(e.z - z_high) / height_tolerance;
    // What is hidden makes a tread shorter, never longer.
    strain = std::max(strain, (edge - low) / config.edge_tolerance_m);
    strain = std::max(strain, (high - (edge + stride.run)) / config.edge_tolerance_m);
    // From above, no more may show over the edge of the step before it. A narrower strip must lie within its
    // step.
    constexpr double kLeastDepth = 0.05;
    constexpr double kWithin = 0.8;
    const double within = std::min(high, edge + stride.run) - std::max(low, edge);
    if (within < std::min({kLeastDepth, 0.25 * stride.run, kWithin * (high - low)})) return std::nullopt;
  }
  if (strain > 1.0) return std::nullopt;
  return StepFit{0, k, 1.0 - strain};
}

double FitSteps(const StaircaseConfig& config, const FlightFrame& frame, const Stride& stride,
                const std::vector<StepElement>& elements, std::vector<StepFit>* fits) {
  std::map<std::pair<int, bool>, double> best;
  for (int i = 0; i < static_cast<int>(elements.size()); ++i) {
    std::optional<StepFit> fit = FitStep(config, frame, stride, elements[i]);
    if (!fit) continue;
    fit->element = i;
    double& quality = best[{fit->step_index, elements[i].riser}];
    quality = std::max(quality, 0.5 + 0.5 * fit->quality);
    if (fits) fits->push_back(*fit);
  }
  double score = 0.0;
  for (const auto& [step, quality] : best) score += quality;
  return score;
}

}  // namespace terrace
