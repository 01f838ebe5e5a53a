// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_finder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "labeling/flight_directions.h"
#include "labeling/flight_ends.h"
#include "labeling/flight_evidence.h"
#include "labeling/flight_frame.h"
#include "labeling/flight_search.h"
#include "labeling/step_elements.h"

namespace terrace {
namespace {

std::optional<FoundStaircase> Complete(const StaircaseConfig& config,
                                       const std::vector<RegionShapePtr>& shapes,
                                       std::optional<Flight> flight, const Sight& sight, bool known) {
  if (!flight) return std::nullopt;
  KeepLongestRun(flight->fits);
  if (flight->fits.empty()) return std::nullopt;
  // The heights of the ends that are near tell the rise better, and so which level one is that is far.
  constexpr int kRounds = 2;
  FlightEnds ends;
  for (int round = 0; round < kRounds; ++round) {
    ends = FindFlightEnds(config, shapes, *flight, sight.ground_z);
    const int last_tread = ends.first_step + ends.num_treads() - 1;
    flight->ends = ends.heights;
    RefineWithin(config, ends.first_step, ends.last_step, last_tread, *flight);
  }
  return WeighFlight(config, shapes, *flight, ends, sight, known);
}

/// A flight that is known to be wider than what is found of it now still is.
void WidenTo(const FlightModel& known, FlightModel& model) {
  if (known.spiral || model.spiral) return;
  const double shift = LeftOf(model.direction).dot(known.origin - model.origin);
  model.lateral = model.lateral.Hull({known.lateral.low + shift, known.lateral.high + shift});
}

/// True when a shape lies among the steps of a flight or continues them to a side: at its place, and about as
/// high as its law is there. What does is one of its steps, or a thing that lies on them, and no other
/// flight.
bool LiesWithin(const FlightModel& model, int num_risers, const RegionShape& shape) {
  const PlacedFrame placed = FrameOf(model);
  const Interval lateral = placed.frame->LateralExtent(shape);
  constexpr double kMostGap_m = 0.1;
  if (lateral.Overlap(placed.lateral) < -kMostGap_m) return false;
  const double step = (shape.centroid.z() - model.foot_z) / model.rise_m;
  const double edge = placed.foot_along_m + (step - 1.0) * model.run_m;
  const double along = placed.frame->Unwrapped(placed.frame->AlongExtent(shape, lateral).middle(), edge);
  return step > 0.0 && step < num_risers + 0.5 && std::abs(along - edge) < 1.5 * model.run_m;
}

}  // namespace

std::vector<FoundStaircase> StaircaseFinder::Find(const std::vector<RegionShapePtr>& shapes,
                                                  const std::vector<FlightModel>& known, const Sight& sight,
                                                  bool compete) const {
  std::vector<StepCandidate> candidates = StepCandidates(config_, shapes, sight.eye());
  std::vector<FoundStaircase> found;
  const auto take = [&](FoundStaircase&& staircase, const FlightModel* followed) {
    FlightModel whole = staircase.model;
    if (followed) WidenTo(*followed, whole);
    std::set<int> used;
    for (const StepMember& member : staircase.members) used.insert(member.shape);
    std::erase_if(candidates, [&](const StepCandidate& c) {
      return used.contains(c.shape) || LiesWithin(whole, staircase.num_risers, *shapes[c.shape]);
    });
    found.push_back(std::move(staircase));
  };

  constexpr int kMaxFlights = 16;
  if (!compete) {
    for (const FlightModel& model : known) {
      std::optional<FoundStaircase> staircase =
          Complete(config_, shapes, FollowFlight(config_, shapes, candidates, model), sight, true);
      if (staircase) take(std::move(*staircase), &model);
    }
  }
  while (candidates.size() >= 2 && found.size() < kMaxFlights) {
    std::optional<FoundStaircase> best;
    double best_score = 0.0;
    const FlightModel* best_followed = nullptr;
    const auto consider = [&](std::optional<Flight> flight, const FlightModel* followed) {
      // A flight that was there before stays unless another explains clearly more.
      const double bonus = followed ? 1.0 : 0.0;
      if (!flight || flight->score + bonus <= best_score) return;
      const double score = flight->score + bonus;
      std::optional<FoundStaircase> staircase =
          Complete(config_, shapes, std::move(flight), sight, followed != nullptr);
      if (!staircase) return;
      best = std::move(staircase);
      best_score = score;
      best_followed = followed;
    };
    for (const FlightModel& model : known) consider(FollowFlight(config_, shapes, candidates, model), &model);
    for (const FlightFramePtr& frame : StraightFrames(config_, shapes, candidates))
      consider(BestFlight(config_, shapes, candidates, frame), nullptr);
    for (const FlightFramePtr& frame : SpiralFrames(config_, shapes, candidates))
      consider(BestFlight(config_, shapes, candidates, frame), nullptr);
    if (!best) break;
    take(std::move(*best), best_followed);
  }
  return found;
}

}  // namespace terrace
