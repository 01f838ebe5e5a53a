// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_values.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace terrace {
namespace {

/// The front of a board, or a rounded edge, hides the tops of all faces alike.
constexpr double kFaceTopsOffset_m = 0.012;
/// Boards are not all as thick.
constexpr double kBoardOffset_m = 0.015;
/// Treads jut out over their risers.
constexpr double kNosingOffset_m = 0.025;

/// Every step says as much as another, whatever the number of its fragments.
class Shares {
 public:
  Shares(const Flight& flight, const std::vector<StepFit>& fits) : flight_(flight) {
    for (const StepFit& fit : fits) area_m2_[KeyOf(fit)] += flight.elements[fit.element].area_m2;
  }
  double Of(const StepFit& fit) const {
    return flight_.elements[fit.element].area_m2 / std::max(1e-9, area_m2_.at(KeyOf(fit)));
  }

 private:
  std::pair<int, bool> KeyOf(const StepFit& fit) const {
    return {fit.step_index, flight_.elements[fit.element].riser};
  }
  const Flight& flight_;
  std::map<std::pair<int, bool>, double> area_m2_;
};

/// How well the front of a tread is known. From below nothing hides its back: what is missing of it may be
/// missing at the front. From above its back is hidden, and the front is what shows.
double FrontSigma(const StepElement& tread, double run_m) {
  if (tread.seen_from_uphill) return tread.front_sigma_m;
  constexpr double kShareAtFront = 0.5;
  const double missing = std::max(0.0, run_m - tread.along.length());
  return std::hypot(tread.front_sigma_m, kShareAtFront * missing);
}

}  // namespace

std::vector<LineValue> StepHeights(const Flight& flight, const std::vector<StepFit>& fits) {
  const Shares shares(flight, fits);
  std::vector<LineValue> values;
  for (const StepFit& fit : fits) {
    const StepElement& e = flight.elements[fit.element];
    if (e.landing && !flight.ends.empty()) continue;  // one of those
    if (e.riser && e.leaning) {                       // its middle is known, and no end of it
      values.push_back({fit.step_index - 0.5, e.z, e.height_sigma_m, shares.Of(fit)});
      continue;
    }
    const double z = e.riser ? e.heights.high : e.z;
    const double offset = e.riser ? kFaceTopsOffset_m : e.underside ? kBoardOffset_m : 0.0;
    values.push_back({static_cast<double>(fit.step_index), z, e.height_sigma_m, shares.Of(fit), offset});
  }
  for (const LevelHeight& end : flight.ends)
    values.push_back({static_cast<double>(end.level), end.z, end.sigma_m});
  return values;
}

std::vector<LineValue> StepPlaces(const Flight& flight, const std::vector<StepFit>& fits) {
  const Shares shares(flight, fits);
  std::vector<LineValue> values;
  for (const StepFit& fit : fits) {
    const StepElement& e = flight.elements[fit.element];
    const double along = flight.frame->Unwrapped(e.along.low, flight.stride.EdgeAt(fit.step_index));
    const double sigma = e.riser ? e.front_sigma_m : FrontSigma(e, flight.stride.run);
    values.push_back({fit.step_index - 1.0, along, sigma, shares.Of(fit), e.riser ? 0.0 : kNosingOffset_m});
  }
  return values;
}

}  // namespace terrace
