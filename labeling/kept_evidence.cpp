// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/kept_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "labeling/slope_evidence.h"

namespace terrace {
namespace {

double OffsetSigma(const TerrainRegion& region) {
  return std::sqrt(std::max(0.0, region.plane_covariance(2, 2)));
}

}  // namespace

RegionExplanation ExplainRegion(const RegionRecord& record, const RegionShape& shape,
                                std::vector<NeighborRegion> neighbors) {
  const TerrainRegion& region = *record.region();
  const LabelEvidence& evidence = record.evidence();
  RegionExplanation e;
  e.id = region.id;
  e.label = region.label;
  e.confidence = region.confidence;
  e.rule = evidence.rule;
  e.slope_rad = shape.slope_rad;
  e.slope_sigma_rad = shape.slope_sigma_rad;
  e.offset_sigma_m = OffsetSigma(region);
  e.rms_m = shape.polygon->rms_m;
  e.noise_m = shape.polygon->noise_m;
  e.area_m2 = shape.area_m2;
  e.num_observations = shape.polygon->num_observations;
  if (evidence.nearest_view_m > 0.0) e.nearest_view_m = evidence.nearest_view_m;
  e.height_m = evidence.height_m;
  const bool decided = evidence.rule != LabelRule::kNotLookedAt;
  if (shape.lean == Lean::kSupport) {
    e.largest_square_m = shape.largest_square_m;
    if (decided) e.large = evidence.large;
    if (decided) e.reachable = evidence.reachable;
  }
  if (shape.lean == Lean::kSupport || shape.lean == Lean::kSteep)
    e.lowest_step_m = LowestStepThatShows(shape);
  if (evidence.decided_by != 0) e.decided_by = evidence.decided_by;
  e.staircase = region.staircase_id;
  e.step_index = region.step_index;
  e.by_itself = evidence.by_itself;
  // A step keeps its label as long as its staircase is told.
  if (!e.staircase && record.num_next() > 0) {
    e.next_label = record.next_label();
    e.num_next = record.num_next();
  }
  e.neighbors = std::move(neighbors);
  return e;
}

RegionExplanation ExplainInferredStep(const TerrainRegion& region) {
  RegionExplanation e;
  e.id = region.id;
  e.label = region.label;
  e.confidence = region.confidence;
  e.rule = LabelRule::kInferredStep;
  e.slope_rad = region.label == TerrainLabel::kStairRiser ? 0.5 * std::numbers::pi : 0.0;
  e.slope_sigma_rad = std::sqrt(std::max(0.0, region.plane_covariance(0, 0)));
  e.offset_sigma_m = OffsetSigma(region);
  e.area_m2 = region.area_m2;
  e.staircase = region.staircase_id;
  e.step_index = region.step_index;
  return e;
}

StaircaseExplanation ExplainStaircase(const TrackedStaircase& staircase) {
  const Staircase& told = staircase.published;
  const StaircaseEvidence& evidence = staircase.found.evidence;
  StaircaseExplanation e;
  e.id = told.id;
  e.confidence = told.confidence;
  e.num_risers = told.num_risers;
  e.num_treads = told.num_treads;
  e.riser_m = told.riser_m;
  e.riser_sigma_m = told.riser_sigma_m;
  e.tread_m = told.tread_m;
  e.tread_sigma_m = told.tread_sigma_m;
  e.pitch_rad = told.pitch_rad;
  std::set<int> risers, treads;  // a step may have several fragments
  for (const StepPlace& place : staircase.places) (place.riser ? risers : treads).insert(place.step_index);
  e.risers_seen.assign(risers.begin(), risers.end());
  e.treads_seen.assign(treads.begin(), treads.end());
  if (staircase.foot_region != 0) e.foot_region = staircase.foot_region;
  if (staircase.head_region != 0) e.head_region = staircase.head_region;
  e.num_seen = evidence.num_seen;
  e.num_to_see = evidence.num_to_see;
  e.seen_sharply = evidence.seen_sharply;
  e.faces_tile = evidence.faces_tile;
  e.sides_agree = evidence.sides_agree;
  e.height_rms_m = evidence.height_rms_m;
  return e;
}

}  // namespace terrace
