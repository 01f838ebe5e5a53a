// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "labeling/flight_values.h"

namespace terrace {
namespace {

/// A few are cut off by the limit of view, and a few run on beside the stairs: the middle one of the ends; of
/// an even number the one of the middle two that is farther out, on both sides alike.
Interval MiddleOf(std::vector<Interval> widths) {
  const auto num = static_cast<std::ptrdiff_t>(widths.size());
  const auto high = widths.begin() + num / 2;
  const auto low = widths.begin() + (num - 1) / 2;
  Interval result;
  std::nth_element(widths.begin(), high, widths.end(),
                   [](const Interval& a, const Interval& b) { return a.high < b.high; });
  result.high = high->high;
  std::nth_element(widths.begin(), low, widths.end(),
                   [](const Interval& a, const Interval& b) { return a.low < b.low; });
  result.low = low->low;
  return result;
}

/// Each step with all its fragments: of a kind, or of both.
std::vector<Interval> WidthsOf(const Flight& flight, const std::vector<StepFit>& fits,
                               std::optional<bool> riser) {
  std::map<std::pair<int, bool>, Interval> steps;
  for (const StepFit& fit : fits) {
    const StepElement& e = flight.elements[fit.element];
    if ((riser && e.riser != *riser) || e.landing) continue;
    Interval& width = steps.try_emplace({fit.step_index, e.riser}, e.lateral).first->second;
    width = width.Hull(e.lateral);
  }
  std::vector<Interval> widths;
  for (const auto& [step, width] : steps) widths.push_back(width);
  return widths;
}

/// The width on which the fitted elements agree; none when none tells it.
std::optional<Interval> WidthOf(const Flight& flight, const std::vector<StepFit>& fits) {
  // Of a face both ends are seen from afar, of a tread often only a part.
  const bool any_riser = std::any_of(fits.begin(), fits.end(),
                                     [&](const StepFit& fit) { return flight.elements[fit.element].riser; });
  std::vector<Interval> widths = WidthsOf(flight, fits, any_riser);
  if (widths.empty()) return std::nullopt;
  Interval width = MiddleOf(std::move(widths));
  if (!flight.frame->spiral()) return width;
  // The steps of a spiral hide the inner ends of those farther up, and nothing goes on beyond its inner side:
  // the step that reaches second farthest in tells where that is.
  widths = WidthsOf(flight, fits, std::nullopt);
  if (widths.size() < 3) return width;
  std::nth_element(widths.begin(), widths.begin() + 1, widths.end(),
                   [](const Interval& a, const Interval& b) { return a.low < b.low; });
  width.low = std::min(width.low, widths[1].low);
  return width;
}

/// The stride on which the fitted elements agree best; none when they do not determine it.
std::optional<Stride> LeastSquares(const Flight& flight, const std::vector<StepFit>& fits) {
  const std::optional<Interval> width = WidthOf(flight, fits);
  if (!width) return std::nullopt;
  const auto z = FitLine(StepHeights(flight, fits));
  const auto along = FitLine(StepPlaces(flight, fits));
  if (!z || !along) return std::nullopt;
  return Stride{along->at_zero, along->slope, z->at_zero, z->slope, *width};
}

}  // namespace

void RefineFlight(const StaircaseConfig& config, Flight& flight) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<StepFit> fits;
    FitSteps(config, *flight.frame, flight.stride, flight.elements, &fits);
    const std::optional<Stride> refined = LeastSquares(flight, fits);
    if (!refined || !refined->Plausible(config) || refined->lateral.length() <= 0.0) break;
    if (FitSteps(config, *flight.frame, *refined, flight.elements, nullptr) < flight.score - 0.5) break;
    flight.stride = *refined;
  }
  flight.fits.clear();
  flight.score = FitSteps(config, *flight.frame, flight.stride, flight.elements, &flight.fits);
}

void RefineWithin(const StaircaseConfig& config, int first, int last, int last_tread, Flight& flight) {
  std::set<int> inside;
  for (const StepFit& fit : flight.fits) {
    const StepElement& e = flight.elements[fit.element];
    const bool fits = fit.step_index <= (e.riser || e.landing ? last : last_tread);
    if (fit.step_index >= first && fits && (!e.landing || fit.step_index == last)) inside.insert(fit.element);
  }
  Flight within = flight;
  within.elements.clear();
  for (const int element : inside) within.elements.push_back(flight.elements[element]);
  within.score = 0.0;
  RefineFlight(config, within);
  // Fewer steps than two kinds of measure need do not determine a law.
  if (within.fits.size() == inside.size()) flight = std::move(within);
}

std::optional<Flight> TurnToMembers(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                    const Flight& flight) {
  if (flight.frame->spiral() || flight.fits.empty()) return std::nullopt;
  const Eigen::Vector2d direction = flight.frame->UpAt(Eigen::Vector2d::Zero());
  Eigen::Vector2d risers = Eigen::Vector2d::Zero();
  Eigen::Vector2d treads = Eigen::Vector2d::Zero();
  std::vector<StepCandidate> members;
  for (const StepFit& fit : flight.fits) {
    const StepElement& e = flight.elements[fit.element];
    const RegionShape& s = *shapes[e.shape];
    members.push_back(e);
    if (e.landing) continue;
    if (e.riser && !e.leaning) {
      risers -= s.area_m2 * s.front();
    } else if (e.leaning) {
      treads -= s.area_m2 * s.plane.normal.head<2>().normalized();
    } else {
      const Eigen::Vector2d across = s.rectangle.short_axis();
      treads += s.rectangle.Elongation() * s.area_m2 *
                (across.dot(direction) > 0.0 ? across : Eigen::Vector2d(-across));
    }
  }
  const Eigen::Vector2d sum = risers.isZero() ? treads : risers;
  if (sum.norm() <= 0.0) return std::nullopt;
  Flight turned;
  turned.frame = std::make_shared<StraightFrame>(sum.normalized());
  turned.stride = flight.stride;
  turned.elements = MeasureSteps(config, shapes, members, *turned.frame);
  // Where each member says that the foot edge is.
  double feet = 0.0, weight = 0.0;
  Interval lateral{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const StepElement& e : turned.elements) {
    const auto fit = std::find_if(flight.fits.begin(), flight.fits.end(), [&](const StepFit& f) {
      return flight.elements[f.element].shape == e.shape;
    });
    const double trust = 1.0 / (e.front_sigma_m * e.front_sigma_m);
    feet += trust * (e.along.low - (fit->step_index - 1) * flight.stride.run);
    weight += trust;
    if (e.landing) continue;
    lateral = lateral.Hull(e.lateral);
  }
  if (weight <= 0.0 || lateral.length() <= 0.0) return std::nullopt;
  turned.stride.along0 = feet / weight;
  turned.stride.lateral = lateral;
  MeasureLandings(shapes, *turned.frame, lateral, turned.elements);
  RefineFlight(config, turned);
  return turned;
}

}  // namespace terrace
