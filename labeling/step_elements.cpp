// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/step_elements.h"

#include <cmath>
#include <numbers>

#include "core/angles.h"
#include "labeling/slope_evidence.h"

namespace terrace {

namespace {

/// Unit vector up the slope, in the plan.
Eigen::Vector2d Uphill(const RegionShape& s) { return -s.plane.normal.head<2>().normalized(); }

/// True when an incline may be a strip of a tread that was merged with those of its neighbours: it departs
/// from its plane, as a level strip does, and lies across the slope.
bool MayBeStripOfTread(const StaircaseConfig& config, const RegionShape& s) {
  if (s.lean != Lean::kSupport && s.lean != Lean::kSteep) return false;
  // One strip may be lower than a step: the residuals are those of all strips of the incline.
  if (!SteepAsStairs(s, config) || !DepartsFromPlane(s, config)) return false;
  return std::abs(s.rectangle.short_axis().dot(Uphill(s))) >= std::cos(Radians(config.max_turn_deg));
}

/// True when a steep strip may be a face that has merged with what shows of the treads at its foot and top:
/// steeper than stairs are, and not upright.
bool MayBeFaceWithTreads(const StaircaseConfig& config, const RegionShape& s) {
  if (s.lean != Lean::kSteep || s.slope_rad <= Radians(config.max_pitch_deg)) return false;
  return std::abs(s.rectangle.short_axis().dot(Uphill(s))) >= std::cos(Radians(config.max_turn_deg));
}

/// Boards of stairs are 3 to 6 cm thick.
constexpr double kBoard = 0.045;

bool MayBeUnderside(const StaircaseConfig& config, const RegionShape& s) {
  return s.lean == Lean::kFacingDown && s.slope_rad >= std::numbers::pi - Radians(config.max_tread_slope_deg);
}

/// How well the front of a tread is known. Noise along its normal moves a point that is seen at a flat angle
/// by so much more along the view.
double TreadFrontSigma(const RegionShape& tread, const Eigen::Vector3d& eye) {
  constexpr double kTreadFrontSigma = 0.025;  // it may be hidden
  constexpr double kLeastAbove = 0.05;
  const double above = std::max(kLeastAbove, std::abs(tread.plane.SignedDistance(eye)));
  const double away = (tread.centroid - eye).head<2>().norm();
  return std::hypot(kTreadFrontSigma, tread.polygon->noise_m * away / above);
}

/// The top of a face, a strip of an incline and a board seen from below tell the height of a tread only
/// about.
void AddSigmas(const RegionShape& shape, const Eigen::Vector3d& eye, StepCandidate& c) {
  constexpr double kRoughHeightSigma = 0.015;
  constexpr double kBestPlace_m = 0.008;
  constexpr double kMergedPlace_m = 0.03;  // treads do not show alike at foot and top
  const double level_sigma = LevelHeightSigma(shape);
  const bool about = c.leaning || c.underside;
  c.height_sigma_m = c.riser ? kRoughHeightSigma
                     : about ? std::max(kRoughHeightSigma, level_sigma)
                             : level_sigma;
  c.front_sigma_m = c.riser ? std::hypot(c.leaning ? kMergedPlace_m : kBestPlace_m, shape.polygon->noise_m)
                            : TreadFrontSigma(shape, eye);
  c.eye = eye.head<2>();
}

}  // namespace

double LevelHeightSigma(const RegionShape& shape) {
  constexpr double kBest_m = 0.003;
  // A floor is large: where it meets the flight its height does not depend on how it leans.
  constexpr double kMostLean_m = 0.02;
  const double lean_m = std::min(kMostLean_m, shape.heights().length()) / std::sqrt(12.0);
  return std::hypot(kBest_m, shape.polygon->rms_m, lean_m);
}

std::vector<StepCandidate> StepCandidates(const StaircaseConfig& config,
                                          const std::vector<RegionShapePtr>& shapes,
                                          const Eigen::Vector3d& eye) {
  // A riser may be seen with a strip of what stands above or below it.
  const double max_face = config.max_riser_m + 2.0 * config.height_tolerance_m;
  // A landing of which little is seen may pass for a tread; its neighbours tell.
  const double max_depth = config.max_tread_m + 2.0 * config.edge_tolerance_m;
  constexpr double kMinFaceHeight = 0.03;
  constexpr double kMinDepth = 0.04;
  // A landing is deeper, and what stands behind a board may be merged with it: its front is what counts.
  constexpr double kMaxBoards = 2.0;
  // Fragments of a step, in pieces.
  constexpr double kMinLength = 0.2;
  std::vector<StepCandidate> candidates;
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    const RegionShape& s = *shapes[i];
    if (s.rectangle.length_m < kMinLength) continue;
    if (MayBeStripOfTread(config, s)) {
      const double depth = s.rectangle.depth_m;
      if (depth >= kMinDepth && depth <= config.max_tread_m) candidates.push_back({i, false, false, true});
    } else if (MayBeFaceWithTreads(config, s)) {
      const double height = s.heights().length();
      if (height >= kMinFaceHeight && height <= max_face) candidates.push_back({i, true, false, true});
    } else if (s.lean == Lean::kUpright) {
      const double height = s.face_heights.length();
      if (height >= kMinFaceHeight && height <= max_face) candidates.push_back({i, true});
    } else if (MayBeUnderside(config, s)) {
      const double depth = s.rectangle.depth_m;
      if (depth >= kMinDepth && depth <= kMaxBoards * max_depth)
        candidates.push_back({i, false, false, false, true});
    } else if (s.lean == Lean::kSupport) {
      const double depth = s.rectangle.depth_m;
      if (s.slope_rad > Radians(config.max_tread_slope_deg) || depth < kMinDepth) continue;
      StepCandidate c{i, false, depth > max_depth};
      c.landing = depth > kMaxBoards * max_depth;
      candidates.push_back(c);
    }
  }
  for (StepCandidate& c : candidates) AddSigmas(*shapes[c.shape], eye, c);
  return candidates;
}

std::vector<StepElement> MeasureSteps(const StaircaseConfig& config,
                                      const std::vector<RegionShapePtr>& shapes,
                                      const std::vector<StepCandidate>& candidates,
                                      const FlightFrame& frame) {
  const double min_cos_riser = std::cos(Radians(config.max_turn_deg));
  // The outline of a tread that is partly seen leans with the limit of view.
  const double min_cos_tread = std::cos(Radians(2.0 * config.max_turn_deg));
  std::vector<StepElement> elements;
  for (const StepCandidate& c : candidates) {
    if (c.landing ? frame.spiral() : c.spiral_only && !frame.spiral()) continue;
    const RegionShape& s = *shapes[c.shape];
    const Eigen::Vector2d up = frame.UpAt(s.rectangle.center);
    // It faces down the stairs, and leans as the flight does.
    if ((c.riser || c.leaning) && Uphill(s).dot(up) < min_cos_riser) continue;
    if (c.leaning && frame.spiral()) continue;
    if (!c.riser && !c.landing && !frame.spiral() && s.rectangle.length_m > 2.0 * s.rectangle.depth_m &&
        std::abs(s.rectangle.short_axis().dot(up)) < min_cos_tread)
      continue;
    StepElement e;
    static_cast<StepCandidate&>(e) = c;
    e.lateral = frame.LateralExtent(s);
    e.along = frame.AlongExtent(s, e.lateral);
    // Of a landing the edge counts.
    const Eigen::Vector2d seen_at =
        c.landing ? frame.PointAt(e.along.low, e.lateral.middle()) : s.rectangle.center;
    e.seen_from_uphill = (seen_at - c.eye).dot(up) < 0.0;
    if (c.landing && !e.seen_from_uphill) continue;
    if (c.riser) e.along = {e.along.middle(), e.along.middle()};
    e.heights = c.riser && !c.leaning ? s.face_heights : s.heights();
    e.z = c.riser ? e.heights.middle() : s.HeightAt(s.rectangle.center);
    if (c.underside) e.z += kBoard;
    e.area_m2 = s.area_m2;
    if (c.leaning) e.min_rise_m = LowestStepThatShows(s);
    elements.push_back(e);
  }
  return elements;
}

void MeasureLandings(const std::vector<RegionShapePtr>& shapes, const FlightFrame& frame,
                     const Interval& lateral, std::vector<StepElement>& elements) {
  for (StepElement& e : elements) {
    if (!e.landing) continue;
    e.along = frame.AlongExtent(*shapes[e.shape], lateral);
    e.z = frame.HeightNear(*shapes[e.shape], e.along.low, lateral.middle());
  }
}

}  // namespace terrace
