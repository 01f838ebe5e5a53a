// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/stair_landings.h"

#include <cmath>

namespace terrace {
namespace {

/// @param k  the number of the riser that would lead to it
bool BeginsBehindRiser(const FlightModel& model, int k, const RegionShape& shape) {
  constexpr double kOfRise = 0.25;
  constexpr double kOfRun = 0.5;
  // Inside the edge, for the outline of a tread below ends there as well.
  const Eigen::Vector2d behind = model.EdgePoint(k + kOfRun, model.lateral.middle());
  Eigen::Vector2d nearest;
  if (shape.PlanDistance(behind, &nearest) > kOfRun * model.run_m) return false;
  return std::abs(shape.HeightAt(nearest) - model.foot_z - k * model.rise_m) < kOfRise * model.rise_m;
}

}  // namespace

std::vector<bool> MayBeLandings(const std::vector<const TrackedStaircase*>& staircases,
                                const std::vector<RegionShapePtr>& shapes) {
  std::vector<bool> landings(shapes.size(), false);
  for (const TrackedStaircase* staircase : staircases) {
    const FlightModel& model = staircase->found.model;
    const int last = staircase->found.num_risers;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      if (landings[i] || shapes[i]->lean != Lean::kSupport) continue;
      landings[i] =
          BeginsBehindRiser(model, last, *shapes[i]) || BeginsBehindRiser(model, last + 1, *shapes[i]);
    }
  }
  return landings;
}

}  // namespace terrace
