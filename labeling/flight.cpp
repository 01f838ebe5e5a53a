// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace terrace {
namespace {

/// The front of a tread is worse known than the place of a face.
constexpr double kTreadEdgeWeight = 0.3;
/// The top of a face is worse known than the height of a level piece. Its foot is hidden by the step in front
/// where the eye is lower, so that its middle says less. An incline of strips, and a board seen from below,
/// tell the height of the tread no better.
constexpr double kFaceHeightWeight = 0.2;

/// One value of a line y = a + b x; those of the second kind share an offset of their own that is not known.
struct LineValue {
  double x = 0.0;
  double y = 0.0;
  double weight = 0.0;
  bool offset = false;
};

/// Least squares: a of the values without offset (none: of the others) and b; none when they do not tell b.
std::optional<std::pair<double, double>> FitLine(const std::vector<LineValue>& values) {
  double xx = 0.0, xy = 0.0;
  std::array<Eigen::Vector2d, 2> middles{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<double, 2> weights{0.0, 0.0};
  for (const bool offset : {false, true}) {
    for (const LineValue& v : values) {
      if (v.offset != offset) continue;
      weights[offset] += v.weight;
      middles[offset] += v.weight * Eigen::Vector2d(v.x, v.y);
    }
    if (weights[offset] <= 0.0) continue;
    middles[offset] /= weights[offset];
    for (const LineValue& v : values) {
      if (v.offset != offset) continue;
      const double dx = v.x - middles[offset].x();
      xx += v.weight * dx * dx;
      xy += v.weight * dx * (v.y - middles[offset].y());
    }
  }
  if (xx < 1e-9) return std::nullopt;
  const Eigen::Vector2d& middle = weights[0] > 0.0 ? middles[0] : middles[1];
  return std::pair(middle.y() - xy / xx * middle.x(), xy / xx);
}

/// A few are cut off by the limit of view, and a few run on beside the stairs: the middle one of the ends.
Interval MiddleOf(std::vector<Interval> widths) {
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  Interval result;
  std::nth_element(widths.begin(), middle, widths.end(),
                   [](const Interval& a, const Interval& b) { return a.high < b.high; });
  result.high = middle->high;
  std::nth_element(widths.begin(), middle, widths.end(),
                   [](const Interval& a, const Interval& b) { return a.low < b.low; });
  result.low = middle->low;
  return result;
}

/// The stride on which the fitted elements agree best; none when they do not determine it.
std::optional<Stride> LeastSquares(const Flight& flight, const std::vector<StepFit>& fits) {
  // The same weight for every step, whatever the number of its fragments.
  std::map<std::pair<int, bool>, double> area;
  for (const StepFit& fit : fits)
    area[{fit.step_index, flight.elements[fit.element].riser}] += flight.elements[fit.element].area_m2;
  std::vector<LineValue> heights, edges;
  // Of a face both ends are seen from afar, of a tread often only a part.
  std::vector<Interval> widths;
  const bool any_riser = std::any_of(fits.begin(), fits.end(),
                                     [&](const StepFit& fit) { return flight.elements[fit.element].riser; });
  for (const StepFit& fit : fits) {
    const StepElement& e = flight.elements[fit.element];
    const double weight = e.area_m2 / std::max(1e-9, area[{fit.step_index, e.riser}]);
    const double along = flight.frame->Unwrapped(e.along.low, flight.stride.EdgeAt(fit.step_index));
    if (e.riser) {
      heights.push_back({static_cast<double>(fit.step_index), e.heights.high, kFaceHeightWeight * weight});
      edges.push_back({fit.step_index - 1.0, along, weight});
    } else {
      heights.push_back({static_cast<double>(fit.step_index), e.z,
                         (e.RoughHeight() ? kFaceHeightWeight : 1.0) * weight, e.underside});
      edges.push_back({fit.step_index - 1.0, along, kTreadEdgeWeight * weight});
    }
    if (e.riser == any_riser) widths.push_back(e.lateral);
  }
  for (const LevelHeight& end : flight.ends) heights.push_back({static_cast<double>(end.level), end.z, 1.0});
  const auto z = FitLine(heights);
  const auto along = FitLine(edges);
  if (!z || !along) return std::nullopt;
  return Stride{along->first, along->second, z->first, z->second, MiddleOf(std::move(widths))};
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
    const bool riser = flight.elements[fit.element].riser;
    if (fit.step_index >= first && fit.step_index <= (riser ? last : last_tread)) inside.insert(fit.element);
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
    members.push_back({e.shape, e.riser, false, e.leaning, e.underside});
    if (e.riser) {
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
    const double trust = e.riser ? 1.0 : kTreadEdgeWeight;
    feet += trust * (e.along.low - (fit->step_index - 1) * flight.stride.run);
    weight += trust;
    lateral = {std::min(lateral.low, e.lateral.low), std::max(lateral.high, e.lateral.high)};
  }
  if (weight <= 0.0) return std::nullopt;
  turned.stride.along0 = feet / weight;
  turned.stride.lateral = lateral;
  RefineFlight(config, turned);
  return turned;
}

}  // namespace terrace
