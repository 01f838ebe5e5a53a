// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_evidence.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace terrace {
namespace {

/// What the members of a flight say about it together.
struct Evidence {
  std::vector<StepMember> members;  ///< ascending by shape
  int num_distinct = 0;             ///< risers and treads seen, however many fragments they have
  int num_levels = 0;
  double spread_z_m = 0.0;
  double spread_along_m = 0.0;
};

Evidence Gather(const Flight& flight, const FlightEnds& ends) {
  const Stride& stride = flight.stride;
  Evidence evidence;
  std::set<std::pair<int, bool>> distinct;
  std::set<int> levels;
  double sum_z2 = 0.0, sum_a2 = 0.0;
  int num_z = 0, num_a = 0;
  for (const StepFit& fit : flight.fits) {
    const StepElement& e = flight.elements[fit.element];
    const int k = fit.step_index - ends.first_step + 1;
    if (k < 1 || k > (e.riser ? ends.num_risers() : ends.num_treads())) continue;
    // A wall that goes on beside and above its riser in one plane shows the riser, but is a wall.
    const double in_riser_m2 = e.lateral.Overlap(stride.lateral) * stride.rise;
    if (!e.riser || e.area_m2 <= 2.0 * in_riser_m2) evidence.members.push_back({e.shape, e.riser, k});
    distinct.insert({k, e.riser});
    levels.insert(k);
    const double edge = stride.EdgeAt(fit.step_index);
    if (e.riser) {
      const double d = flight.frame->Unwrapped(e.along.low, edge) - edge;
      sum_a2 += d * d;
      ++num_a;
    } else {
      const double d = e.z - stride.z0 - fit.step_index * stride.rise;
      sum_z2 += d * d;
      ++num_z;
    }
  }
  std::sort(evidence.members.begin(), evidence.members.end(),
            [](const StepMember& a, const StepMember& b) { return a.shape < b.shape; });
  evidence.num_distinct = static_cast<int>(distinct.size());
  evidence.num_levels = static_cast<int>(levels.size());
  // A spread from few steps is worth little: a centimetre is known beforehand.
  constexpr double kPriorSigma = 0.01;
  const double prior2 = kPriorSigma * kPriorSigma;
  evidence.spread_z_m = std::sqrt((sum_z2 + prior2) / (num_z + 1));
  evidence.spread_along_m = std::sqrt((sum_a2 + 4.0 * prior2) / (num_a + 1));
  return evidence;
}

}  // namespace

std::optional<FoundStaircase> WeighFlight(const StaircaseConfig& config, const Flight& flight,
                                          const FlightEnds& ends, bool known) {
  const Stride& stride = flight.stride;
  if (ends.num_risers() < 2 || ends.num_treads() < 1) return std::nullopt;
  Evidence evidence = Gather(flight, ends);
  const double seen = static_cast<double>(evidence.num_distinct) / (ends.num_risers() + ends.num_treads());
  if (stride.lateral.length() < config.min_width_m || evidence.num_levels < 2) return std::nullopt;
  // Floor and landing in their places are evidence as well. Direction, rise, run and place of a flight can be
  // chosen so that almost any three shapes obey.
  const int num_seen = evidence.num_distinct + (ends.foot_shape ? 1 : 0) + (ends.head_shape ? 1 : 0);
  if (evidence.members.empty() || evidence.num_distinct < 2 || num_seen < (known ? 3 : 4))
    return std::nullopt;
  if (seen < (known ? 0.3 : 0.45)) return std::nullopt;
  // Two boxes make two risers as well: then floor, landing and all that lies between must be there.
  const bool both_ends = ends.foot_shape && ends.head_shape;
  if (ends.num_risers() == 2 && !(both_ends && evidence.num_distinct >= 3)) return std::nullopt;

  FoundStaircase found;
  found.model = flight.frame->ModelAt(stride.EdgeAt(ends.first_step), stride.lateral);
  found.model.rise_m = stride.rise;
  found.model.run_m = stride.run;
  found.model.foot_z = stride.z0 + (ends.first_step - 1) * stride.rise;
  found.num_risers = ends.num_risers();
  found.num_treads = ends.num_treads();
  found.foot_shape = ends.foot_shape;
  found.head_shape = ends.head_shape;
  found.members = std::move(evidence.members);
  const double span = std::max(1, found.num_risers - 1);
  found.rise_sigma_m = evidence.spread_z_m / span;
  found.run_sigma_m = evidence.spread_along_m / span;
  const double enough = 1.0 - std::exp(-0.5 * (num_seen - 1.0));
  const double good = std::exp(-0.25 * std::pow(evidence.spread_z_m / config.height_tolerance_m, 2));
  found.confidence = std::clamp(enough * good * (0.6 + 0.4 * seen), 0.0, 1.0);
  if (found.confidence < (known ? 0.6 : 1.0) * config.min_confidence) return std::nullopt;
  return found;
}

}  // namespace terrace
