// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_evidence.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace terrace {
namespace {

/// A step that a staircase has: its number, and whether it is the riser.
using StepKey = std::pair<int, bool>;

/// What the members of a flight say about it together.
struct Evidence {
  std::vector<StepMember> members;  ///< ascending by shape
  std::set<StepKey> seen;           ///< however many fragments they have
  int num_levels = 0;
  bool faces_tile = false;  ///< at least two faces reach from one step to the next
  bool sides_agree = false;
  double chi2_z = 0.0;  ///< sum of squared departures over what each kind of member is good for
  double chi2_along = 0.0;
  int num_z = 0;
  int num_along = 0;
};

/// What single members are good for: the height of a tread; the middle height of a face, of which a part may
/// be hidden; the place of a face; the front of a tread, which may be hidden.
constexpr double kTreadHeightSigma = 0.006;
constexpr double kFaceHeightSigma = 0.015;
constexpr double kFacePlaceSigma = 0.010;
constexpr double kTreadFrontSigma = 0.025;

bool SidesAgree(const std::vector<Interval>& sides) {
  constexpr double kSame = 0.8;
  for (const Interval& a : sides)
    for (const Interval& b : sides)
      if (a.Overlap(b) < kSame * std::min(a.length(), b.length())) return false;
  return true;
}

Evidence Gather(const Flight& flight, const FlightEnds& ends) {
  const Stride& stride = flight.stride;
  Evidence evidence;
  std::set<int> levels, whole_faces;
  std::vector<Interval> sides;
  for (const StepFit& fit : flight.fits) {
    const StepElement& e = flight.elements[fit.element];
    const int k = fit.step_index - ends.first_step + 1;
    if (k < 1 || k > (e.riser ? ends.num_risers() : ends.num_treads())) continue;
    // A wall that goes on beside and above its riser in one plane shows the riser, but is a wall.
    const double in_riser_m2 = e.lateral.Overlap(stride.lateral) * stride.rise;
    if (!e.riser || e.area_m2 <= 2.0 * in_riser_m2)
      evidence.members.push_back({e.shape, e.riser, k, e.leaning});
    evidence.seen.insert({k, e.riser});
    levels.insert(k);
    sides.push_back(e.lateral);
    const double edge = stride.EdgeAt(fit.step_index);
    const double along = flight.frame->Unwrapped(e.along.low, edge) - edge;
    const double z = e.z - stride.z0 - (e.riser ? fit.step_index - 0.5 : fit.step_index) * stride.rise;
    evidence.chi2_z += std::pow(z / (e.riser ? kFaceHeightSigma : kTreadHeightSigma), 2);
    ++evidence.num_z;
    if (e.riser) {
      // The step in front hides a part of a face from below, a strip of a neighbour makes it higher.
      const double share = e.heights.length() / stride.rise;
      if (share > 0.55 && share < 1.3) whole_faces.insert(k);
      evidence.chi2_along += std::pow(along / kFacePlaceSigma, 2);
      ++evidence.num_along;
    }
  }
  std::sort(evidence.members.begin(), evidence.members.end(),
            [](const StepMember& a, const StepMember& b) { return a.shape < b.shape; });
  evidence.num_levels = static_cast<int>(levels.size());
  evidence.faces_tile = whole_faces.size() >= 2;
  evidence.sides_agree = SidesAgree(sides);
  return evidence;
}

/// The steps that the camera could see from where it is, and those that were seen.
std::set<StepKey> StepsToBeSeen(const FlightModel& model, const FlightEnds& ends, const Sight& sight,
                                const std::set<StepKey>& seen) {
  constexpr double kAboveTread = 0.05;  // lower than this over a tread, the camera sees a line of it
  std::set<StepKey> steps = seen;
  for (int k = 1; k <= ends.num_risers(); ++k) {
    const Eigen::Vector2d edge = model.EdgePoint(k, model.lateral.middle());
    if (model.UpAt(k).dot(edge - sight.eye().head<2>()) > 0.0) steps.insert({k, true});
    if (k <= ends.num_treads() && sight.eye().z() > model.foot_z + k * model.rise_m + kAboveTread)
      steps.insert({k, false});
  }
  return steps;
}

/// A narrow thing of which both sides are in view is furniture rather than a staircase.
bool StandsFree(const FlightModel& model, int num_risers, const Sight& sight) {
  constexpr double kWide = 0.9;
  constexpr double kBeside = 0.1;
  if (model.lateral.length() >= kWide) return false;
  const double k = 0.5 * (1 + num_risers);
  const double z = model.foot_z + 0.5 * num_risers * model.rise_m;
  const auto in_view = [&](double lateral) {
    const Eigen::Vector2d p = model.EdgePoint(k, lateral);
    return sight.InView({p.x(), p.y(), z});
  };
  return in_view(model.lateral.low - kBeside) && in_view(model.lateral.high + kBeside);
}

/// Standard deviation of the slope of a line through values, one a level, each with a standard deviation.
double SlopeSigma(double sigma_m, double chi2, int num, double num_levels) {
  // The law has two numbers; a few values scatter by chance, so that what was known beforehand counts as two.
  const double scatter2 = (chi2 + 2.0) / std::max(1.0, num - 2.0 + 2.0);
  const double spread2 =
      num_levels * (num_levels * num_levels - 1.0) / 12.0;  // of 1, 2, ... about their mean
  return sigma_m * std::sqrt(std::max(1.0, scatter2) / std::max(0.5, spread2));
}

/// True when most members are seen so well that what they say of a step can be relied on: noise moves them by
/// less than a sixteenth of the rise.
bool SeenSharply(const std::vector<StepMember>& members, const std::vector<RegionShapePtr>& shapes,
                 double rise_m) {
  const auto num_sharp = std::count_if(members.begin(), members.end(), [&](const StepMember& member) {
    return shapes[member.shape]->polygon->noise_m <= rise_m / 16.0;
  });
  return 2 * num_sharp > static_cast<std::ptrdiff_t>(members.size());
}

}  // namespace

std::optional<FoundStaircase> WeighFlight(const StaircaseConfig& config,
                                          const std::vector<RegionShapePtr>& shapes, const Flight& flight,
                                          const FlightEnds& ends, const Sight& sight, bool known) {
  const Stride& stride = flight.stride;
  if (ends.num_risers() < 2 || ends.num_treads() < 1) return std::nullopt;
  Evidence evidence = Gather(flight, ends);
  const int num_steps = static_cast<int>(evidence.seen.size());
  if (stride.lateral.length() < config.min_width_m || evidence.num_levels < 2) return std::nullopt;
  if (evidence.members.empty() || num_steps < 2) return std::nullopt;

  FoundStaircase found;
  found.model = flight.frame->ModelAt(stride.EdgeAt(ends.first_step), stride.lateral);
  found.model.rise_m = stride.rise;
  found.model.run_m = stride.run;
  found.model.foot_z = stride.z0 + (ends.first_step - 1) * stride.rise;
  // From afar all steps are missed that are not seen: what hides and what blurs cannot be told apart.
  const bool sharp = SeenSharply(evidence.members, shapes, stride.rise);
  const std::size_t num_to_see = sharp ? StepsToBeSeen(found.model, ends, sight, evidence.seen).size()
                                       : static_cast<std::size_t>(ends.num_risers() + ends.num_treads());
  const double seen = static_cast<double>(num_steps) / static_cast<double>(num_to_see);

  const int num_ends = (ends.foot_shape ? 1 : 0) + (ends.head_shape ? 1 : 0);
  const int num_pieces = num_steps + num_ends;
  const bool any_riser =
      std::any_of(evidence.seen.begin(), evidence.seen.end(), [](const StepKey& key) { return key.second; });
  const int num_agreements = (evidence.faces_tile ? 1 : 0) + (evidence.sides_agree ? 1 : 0);
  // One riser may lie between the ground and what is seen.
  const bool grounded = num_ends > 0 || std::abs(found.model.foot_z - sight.ground_z) < 1.2 * stride.rise;
  const bool free = StandsFree(found.model, ends.num_risers(), sight);
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
  if (ends.num_risers() == 2 && !whole && !few_that_agree && !stays) return std::nullopt;

  found.num_risers = ends.num_risers();
  found.num_treads = ends.num_treads();
  found.foot_shape = ends.foot_shape;
  found.head_shape = ends.head_shape;
  found.members = std::move(evidence.members);
  const double levels = evidence.num_levels;
  found.rise_sigma_m = SlopeSigma(kTreadHeightSigma, evidence.chi2_z, evidence.num_z, levels);
  found.run_sigma_m = any_riser ? SlopeSigma(kFacePlaceSigma, evidence.chi2_along, evidence.num_along, levels)
                                : SlopeSigma(kTreadFrontSigma, 0.0, 2, levels);
  const int num_agreeing = sharp ? num_agreements : 0;
  const double enough = 1.0 - std::exp(-0.5 * (num_pieces + num_agreeing - 1.0));
  const double scatter2 = evidence.chi2_z / evidence.num_z * std::pow(kTreadHeightSigma, 2);
  const double good = std::exp(-0.25 * scatter2 / std::pow(config.HeightTolerance(stride.rise), 2));
  found.confidence = std::clamp(enough * good * (0.6 + 0.4 * seen), 0.0, 1.0);
  if (found.confidence < (known ? 0.6 : 1.0) * config.min_confidence) return std::nullopt;
  return found;
}

}  // namespace terrace
