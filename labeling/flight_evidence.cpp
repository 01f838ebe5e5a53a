// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "labeling/flight_values.h"

namespace terrace {
namespace {

/// A step that a staircase has: its number, and whether it is the riser.
using StepKey = std::pair<int, bool>;

/// What the members of a flight say about it together.
struct Evidence {
  std::vector<StepMember> members;  ///< ascending by shape
  std::set<StepKey> seen;           ///< however many fragments they have
  int num_levels = 0;
  bool any_whole_face = false;  ///< that reaches over most of the rise: the front of a board does not
  bool any_underside = false;
  bool faces_tile = false;  ///< faces of two neighbouring steps reach from one to the next
  bool sides_agree = false;
  bool landing_edge = false;     ///< the edge of the landing was seen from above
  double widest_m = 0.0;         ///< of all steps
  std::optional<LineFit> z;      ///< heights over step indices; none: they do not tell the rise
  std::optional<LineFit> along;  ///< places of the edges over step indices
};

/// @param sides  of each step, all its fragments together
bool SidesAgree(const std::map<StepKey, Interval>& sides) {
  constexpr double kSame = 0.8;
  for (const auto& [step_a, a] : sides)
    for (const auto& [step_b, b] : sides)
      if (a.Overlap(b) < kSame * std::min(a.length(), b.length())) return false;
  return true;
}

Evidence Gather(const Flight& flight, const FlightEnds& ends) {
  const Stride& stride = flight.stride;
  Evidence evidence;
  std::set<int> levels, whole_faces;
  std::vector<StepFit> counted;
  std::map<StepKey, Interval> sides;
  for (const StepFit& fit : flight.fits) {
    const StepElement& e = flight.elements[fit.element];
    const int k = fit.step_index - ends.first_step + 1;
    if (e.landing) {
      if (k != ends.num_risers() || !ends.head_shape) continue;
      counted.push_back(fit);
      evidence.landing_edge = true;
      continue;
    }
    if (k < 1 || k > (e.riser ? ends.num_risers() : ends.num_treads())) continue;
    counted.push_back(fit);
    // A wall that goes on beside and above its riser in one plane shows the riser, but is a wall.
    const double in_riser_m2 = e.lateral.Overlap(stride.lateral) * stride.rise;
    if (!e.riser || e.area_m2 <= 2.0 * in_riser_m2)
      evidence.members.push_back({e.shape, e.riser, k, e.leaning || e.underside});
    evidence.seen.insert({k, e.riser});
    levels.insert(k);
    Interval& side = sides.try_emplace({k, e.riser}, e.lateral).first->second;
    side = side.Hull(e.lateral);
    if (e.riser && !e.leaning) {
      // The step in front hides a part of a face from below, a strip of a neighbour makes it higher.
      const double whole = e.heights.length() / stride.rise;
      if (whole > 0.55 && whole < 1.3) whole_faces.insert(k);
    }
    evidence.any_underside |= e.underside;
  }
  evidence.z = FitLine(StepHeights(flight, counted));
  evidence.along = FitLine(StepPlaces(flight, counted));
  std::sort(evidence.members.begin(), evidence.members.end(),
            [](const StepMember& a, const StepMember& b) { return a.shape < b.shape; });
  evidence.num_levels = static_cast<int>(levels.size());
  evidence.any_whole_face = !whole_faces.empty();
  evidence.faces_tile =
      std::any_of(whole_faces.begin(), whole_faces.end(), [&](int k) { return whole_faces.contains(k + 1); });
  evidence.sides_agree = SidesAgree(sides);
  for (const auto& [step, side] : sides) evidence.widest_m = std::max(evidence.widest_m, side.length());
  return evidence;
}

/// True when the floor at the foot is seen beneath most of the treads: no face can stand there.
bool FloorSeenBeneath(const FlightModel& model, const FlightEnds& ends, const std::set<StepKey>& seen,
                      const std::vector<RegionShapePtr>& shapes) {
  if (!ends.foot_shape) return false;
  const RegionShape& floor = *shapes[*ends.foot_shape];
  int num_floor = 0, num = 0;
  for (const auto& [k, riser] : seen) {
    if (riser) continue;
    for (const double share : {0.2, 0.4, 0.6, 0.8}) {
      const double lateral = model.lateral.low + share * model.lateral.length();
      ++num;
      num_floor += floor.PlanDistance(model.EdgePoint(k + 0.5, lateral)) <= 0.0;
    }
  }
  return num > 0 && 2 * num_floor >= num;
}

/// Treads above each other with the same sides, and no face that reaches from one to the next where all is
/// seen sharply: three of them, or two with the floor beneath, or one of them from below. Its risers are
/// open, and none is missed; what is seen of them is the front of the boards.
bool HasOpenRisers(const Evidence& evidence, const FlightModel& model, const FlightEnds& ends,
                   const std::vector<RegionShapePtr>& shapes) {
  constexpr int kEnoughTreads = 3;
  if (evidence.any_whole_face || !evidence.sides_agree) return false;
  const auto num_treads = std::count_if(evidence.seen.begin(), evidence.seen.end(),
                                        [](const StepKey& key) { return !key.second; });
  if (num_treads >= 2 && (evidence.any_underside || FloorSeenBeneath(model, ends, evidence.seen, shapes)))
    return true;
  return num_treads >= kEnoughTreads && num_treads == static_cast<std::ptrdiff_t>(evidence.seen.size());
}

/// How much of a tread shows: from above, the edge of the step before it hides the part next to its riser.
double DepthThatShows(const FlightModel& model, int k, const Sight& sight) {
  const Eigen::Vector2d edge = model.EdgePoint(k + 1, model.lateral.middle());
  const double before = model.UpAt(k + 1).dot(sight.eye().head<2>() - edge);
  if (before <= 0.0) return model.run_m;
  const double above = sight.eye().z() - model.foot_z - (k + 1) * model.rise_m;
  return above > 0.0 ? model.run_m - model.rise_m * before / above : 0.0;
}

/// Whether a tread lies in a slope as steep as the flight, in which its steps have merged from afar: then it
/// is not resolved yet rather than missing.
bool LiesInSlope(const FlightModel& model, int k, const std::vector<RegionShapePtr>& shapes) {
  constexpr double kAlike_rad = 0.2;
  constexpr double kWithin = 0.6;  // of the rise
  // The outer part of a tread is what shows of it from above.
  constexpr double kOuter = 0.25;
  const Eigen::Vector2d p = model.EdgePoint(k + kOuter, model.lateral.middle());
  const double z = model.foot_z + k * model.rise_m;
  const double pitch_rad = std::atan2(model.rise_m, model.run_m);
  return std::any_of(shapes.begin(), shapes.end(), [&](const RegionShapePtr& shape) {
    return std::abs(shape->slope_rad - pitch_rad) < kAlike_rad && shape->PlanDistance(p) <= 0.0 &&
           std::abs(shape->HeightAt(p) - z) < kWithin * model.rise_m;
  });
}

/// The steps that the camera could see from where it is, and those that were seen.
std::set<StepKey> StepsToBeSeen(const FlightModel& model, const FlightEnds& ends, const Sight& sight,
                                const Evidence& evidence, const std::vector<RegionShapePtr>& shapes) {
  constexpr double kAboveTread = 0.05;  // lower than this over a tread, the camera sees a line of it
  constexpr double kShows = 0.10;       // narrower strips merge with those beside them, or are lost
  std::set<StepKey> steps = evidence.seen;
  const bool open = HasOpenRisers(evidence, model, ends, shapes);
  for (int k = 1; k <= ends.num_risers(); ++k) {
    const Eigen::Vector2d edge = model.EdgePoint(k, model.lateral.middle());
    if (!open && model.UpAt(k).dot(edge - sight.eye().head<2>()) > 0.0) steps.insert({k, true});
    if (k <= ends.num_treads() && sight.eye().z() > model.foot_z + k * model.rise_m + kAboveTread &&
        DepthThatShows(model, k, sight) >= kShows && !LiesInSlope(model, k, shapes))
      steps.insert({k, false});
  }
  return steps;
}

/// The floor below a flight that is known by the edge above it; else null.
const RegionShape* FloorBelowEdge(const Evidence& evidence, const FlightEnds& ends,
                                  const std::vector<RegionShapePtr>& shapes) {
  return evidence.landing_edge && ends.foot_shape ? shapes[*ends.foot_shape].get() : nullptr;
}

/// A narrow thing of which both sides are in view is furniture rather than a staircase. Of a strip of a tread
/// below an edge the sides are known only where the floor shows beside it, through where the tread would go
/// on.
/// @param floor_below  see FloorBelowEdge
bool StandsFree(const FlightModel& model, int num_risers, const Sight& sight,
                const RegionShape* floor_below) {
  constexpr double kWide = 0.9;
  constexpr double kBeside = 0.1;
  constexpr double kNear = 0.05;  // so near to the edge above, little of the floor shows
  if (model.lateral.length() >= kWide) return false;
  const Eigen::Vector3d eye = sight.eye();
  const double tread_z = model.foot_z + (num_risers - 1) * model.rise_m;
  const auto ends_before = [&](double lateral) {
    if (!floor_below || eye.z() <= tread_z) {
      const Eigen::Vector2d p = model.EdgePoint(0.5 * (1 + num_risers), lateral);
      return sight.InView({p.x(), p.y(), model.foot_z + 0.5 * num_risers * model.rise_m});
    }
    const Eigen::Vector2d p = model.EdgePoint(num_risers - 1, lateral);
    const double onward = (eye.z() - model.foot_z) / (eye.z() - tread_z);
    return floor_below->PlanDistance(eye.head<2>() + onward * (p - eye.head<2>())) <= kNear;
  };
  return ends_before(model.lateral.low - kBeside) && ends_before(model.lateral.high + kBeside);
}

/// Of a spiral the treads are told at the middle of the width, which is as well known as its inner side: that
/// lies anywhere between what is seen and the axis, more likely near what is seen.
double RunSigma(double sigma_at_radius_m, const FlightModel& model) {
  if (!model.spiral) return sigma_at_radius_m;
  constexpr double kShareOfInner = 0.25;
  constexpr double kBestMiddle_m = 0.03;
  const double middle_sigma_m = std::max(kBestMiddle_m, kShareOfInner * model.lateral.low);
  return std::hypot(sigma_at_radius_m, model.run_m / model.radius_m * middle_sigma_m);
}

/// True when most members are seen so well that what they say of a step can be relied on: noise moves them by
/// less than a sixteenth of the rise. Far faces that have merged with their treads are known to be blurred.
bool SeenSharply(const std::vector<StepMember>& members, const std::vector<RegionShapePtr>& shapes,
                 double rise_m) {
  int num = 0, num_sharp = 0;
  for (const StepMember& member : members) {
    if (member.riser && member.only_evidence) continue;
    ++num;
    num_sharp += shapes[member.shape]->polygon->noise_m <= rise_m / 16.0;
  }
  return 2 * num_sharp > num;
}

/// One step is enough between the edge of a landing and the floor below, else it takes two.
bool TellsALaw(const Evidence& evidence, const FlightEnds& ends) {
  const int least = evidence.landing_edge && ends.foot_shape ? 1 : 2;
  return !evidence.members.empty() && static_cast<int>(evidence.seen.size()) >= least &&
         evidence.num_levels >= least && evidence.z && evidence.along;
}

/// @param num_pieces  that speak for the flight
/// @param seen  share of the steps that could be seen
/// @param height_rms  of the steps about the law, in tolerances
double ConfidenceOf(int num_pieces, double seen, double height_rms) {
  const double enough = 1.0 - std::exp(-0.5 * (num_pieces - 1.0));
  const double good = std::exp(-0.25 * std::pow(height_rms, 2));
  return std::clamp(enough * good * (0.6 + 0.4 * seen), 0.0, 1.0);
}

FlightModel ModelOf(const Flight& flight, const FlightEnds& ends) {
  const Stride& stride = flight.stride;
  FlightModel model = flight.frame->ModelAt(stride.EdgeAt(ends.first_step), stride.lateral);
  model.rise_m = stride.rise;
  model.run_m = stride.run;
  model.foot_z = stride.z0 + (ends.first_step - 1) * stride.rise;
  return model;
}

}  // namespace

std::optional<FoundStaircase> WeighFlight(const StaircaseConfig& config,
                                          const std::vector<RegionShapePtr>& shapes, const Flight& flight,
                                          const FlightEnds& ends, const Sight& sight, bool known) {
  const Stride& stride = flight.stride;
  if (ends.num_risers() < 2 || ends.num_treads() < 1) return std::nullopt;
  Evidence evidence = Gather(flight, ends);
  const int num_steps = static_cast<int>(evidence.seen.size());
  if (evidence.widest_m < config.min_width_m || !TellsALaw(evidence, ends)) return std::nullopt;

  FoundStaircase found;
  found.model = ModelOf(flight, ends);
  // From afar all steps are missed that are not seen: what hides and what blurs cannot be told apart.
  const bool sharp = SeenSharply(evidence.members, shapes, stride.rise);
  const std::size_t num_to_see = sharp ? StepsToBeSeen(found.model, ends, sight, evidence, shapes).size()
                                       : static_cast<std::size_t>(ends.num_risers() + ends.num_treads());
  const double seen = static_cast<double>(num_steps) / static_cast<double>(num_to_see);

  const int num_ends = (ends.foot_shape ? 1 : 0) + (ends.head_shape ? 1 : 0);
  const bool free = StandsFree(found.model, ends.num_risers(), sight, FloorBelowEdge(evidence, ends, shapes));
  // An incline that goes on as the steps do, and is no plane, is as good as two of them.
  const int num_merged = free ? 0 : std::min(ends.num_merged, 2);
  const int num_pieces = num_steps + num_ends + num_merged;
  const bool any_riser = std::any_of(evidence.seen.begin(), evidence.seen.end(),
                                     [](const StepKey& key) { return key.second; }) &&
                         !HasOpenRisers(evidence, found.model, ends, shapes);
  const int num_agreements = (evidence.faces_tile ? 1 : 0) + (evidence.sides_agree ? 1 : 0);
  // One riser may lie between the ground and what is seen.
  const bool grounded = num_ends > 0 || std::abs(found.model.foot_z - sight.ground_z) < 1.2 * stride.rise;
  const bool enough_pieces = num_pieces >= 4 && seen >= 0.45;
  // The ground in front of the first step is missed only where it could be seen.
  const Eigen::Vector2d foot = found.model.EdgePoint(1.0, found.model.lateral.middle());
  const int min_pieces = sight.InView({foot.x(), foot.y(), found.model.foot_z}) ? 3 : 2;
  const bool few_that_agree = sharp && num_pieces >= min_pieces && grounded && !free && seen >= 0.45 &&
                              num_agreements == (any_riser ? 2 : 1);
  const bool stays = known && num_pieces >= 3 && seen >= 0.3;
  if (!stays && !enough_pieces && !few_that_agree) return std::nullopt;
  // Two boxes make two risers as well: then floor, landing and all that lies between must be there.
  const bool whole = ends.foot_shape && ends.head_shape && num_steps >= 3;
  if (ends.num_risers() + num_merged == 2 && !whole && !few_that_agree && !stays) return std::nullopt;

  found.num_risers = ends.num_risers() + ends.num_merged;
  // What lies behind the last of the merged risers is not known.
  found.num_treads = ends.num_merged > 0 ? found.num_risers - 1 : ends.num_treads();
  found.foot_shape = ends.foot_shape;
  found.head_shape = ends.head_shape;
  found.evidence = {num_steps,           static_cast<int>(num_to_see), sharp,
                    evidence.faces_tile, evidence.sides_agree,         evidence.z->rms};
  found.members = std::move(evidence.members);
  found.rise_sigma_m = evidence.z->slope_sigma;
  found.run_sigma_m = RunSigma(evidence.along->slope_sigma, found.model);
  // Told with a wrong run, feet would be set wrongly: better told later.
  constexpr double kKnownWithin = 0.25;
  if (!known && found.run_sigma_m > kKnownWithin * stride.run) return std::nullopt;
  found.confidence = ConfidenceOf(num_pieces + (sharp ? num_agreements : 0), seen,
                                  evidence.z->rms / config.HeightTolerance(stride.rise));
  if (found.confidence < (known ? 0.6 : 1.0) * config.min_confidence) return std::nullopt;
  return found;
}

}  // namespace terrace
