// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_search.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

/// Keeps the best of the strides that are proposed.
class StrideContest {
 public:
  StrideContest(const StaircaseConfig& config, const FlightFrame& frame,
                const std::vector<StepElement>& elements)
      : config_(config), frame_(frame), elements_(elements) {}

  /// Two elements of a kind one or two steps apart, with where their steps begin.
  void Propose(const StepElement& low, double edge_low, const StepElement& high, double edge_high) {
    for (int steps = 1; steps <= 2; ++steps) {
      Stride stride;
      stride.rise = (high.z - low.z) / steps;
      if (stride.rise < config_.min_riser_m || stride.rise > config_.max_riser_m) continue;
      const double hint = edge_low + steps * 0.5 * (config_.min_tread_m + config_.max_tread_m);
      stride.run = (frame_.Unwrapped(edge_high, hint) - edge_low) / steps;
      stride.along0 = edge_low;
      stride.z0 = low.riser ? low.z - 0.5 * stride.rise : low.z - stride.rise;
      if (!stride.Plausible(config_)) continue;
      stride.lateral = high.landing ? WidthOfStep(low) : low.lateral.Hull(high.lateral);
      const double score = FitSteps(config_, frame_, stride, elements_, nullptr);
      if (score <= score_) continue;
      score_ = score;
      best_ = stride;
    }
  }
  const std::optional<Stride>& best() const { return best_; }
  double score() const { return score_; }

 private:
  /// Of what shows of a tread below a landing, with all that may be fragments of it: at its height and place.
  Interval WidthOfStep(const StepElement& element) const {
    constexpr double kSameHeight_m = 0.015;
    Interval width = element.lateral;
    for (const StepElement& e : elements_)
      if (!e.riser && !e.landing && std::abs(e.z - element.z) < kSameHeight_m &&
          e.along.Overlap(element.along) > -kSameHeight_m)
        width = width.Hull(e.lateral);
    return width;
  }

  const StaircaseConfig& config_;
  const FlightFrame& frame_;
  const std::vector<StepElement>& elements_;
  double score_ = 1.5;  ///< the two elements that make the hypothesis obey it anyhow
  std::optional<Stride> best_;
};

/// The direction was a rough vote of everything about: its own members know better.
Flight Turned(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes, Flight flight) {
  std::optional<Flight> turned = TurnToMembers(config, shapes, flight);
  return turned && turned->score > flight.score - 0.5 ? std::move(*turned) : std::move(flight);
}

}  // namespace

std::optional<Flight> BestFlight(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                 const std::vector<StepCandidate>& candidates, const FlightFramePtr& frame) {
  Flight flight{frame, MeasureSteps(config, shapes, candidates, *frame), {}, {}, {}, 0.0};
  StrideContest contest(config, *frame, flight.elements);
  for (const StepElement& low : flight.elements) {
    for (const StepElement& high : flight.elements) {
      if (low.riser != high.riser || low.landing || high.z <= low.z) continue;
      if (low.lateral.Overlap(high.lateral) < 0.5 * config.min_width_m) continue;
      const double edge_high =
          high.landing ? frame->AlongExtent(*shapes[high.shape], low.lateral).low : high.along.low;
      contest.Propose(low, low.along.low, high, edge_high);
      if (low.riser || high.landing) continue;
      // When the front of a tread is hidden its back may be seen.
      const double run = high.along.high - low.along.high;
      contest.Propose(low, low.along.high - run, high, low.along.high);
    }
  }
  if (!contest.best()) return std::nullopt;
  flight.stride = *contest.best();
  flight.score = contest.score();
  MeasureLandings(shapes, *frame, flight.stride.lateral, flight.elements);
  RefineFlight(config, flight);
  return Turned(config, shapes, std::move(flight));
}

std::optional<Flight> FollowFlight(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                   const std::vector<StepCandidate>& candidates, const FlightModel& known) {
  const PlacedFrame placed = FrameOf(known);
  Flight flight;
  flight.frame = placed.frame;
  flight.elements = MeasureSteps(config, shapes, candidates, *placed.frame);
  MeasureLandings(shapes, *placed.frame, placed.lateral, flight.elements);
  flight.stride = {placed.foot_along_m, known.run_m, known.foot_z, known.rise_m, placed.lateral};
  RefineFlight(config, flight);
  if (flight.fits.empty()) return std::nullopt;
  return Turned(config, shapes, std::move(flight));
}

}  // namespace terrace
