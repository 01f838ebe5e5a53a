// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/region_record.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "labeling/why_undecided.h"

namespace terrace {

Verdict RegionRecord::Steady(const Verdict& verdict, int frames_to_change) {
  // Calling stairs a ramp is the worst mistake: a ramp is told late and taken back at once.
  Verdict undecided(TerrainLabel::kUnknown, 0.4, LabelRule::kSlopeJustSeen);
  undecided.evidence = verdict.evidence;
  undecided.evidence.rule = LabelRule::kSlopeJustSeen;
  if (!region_) return verdict.label == TerrainLabel::kRamp ? undecided : verdict;
  const TerrainLabel told = region_->label;
  if (verdict.label == told) {
    num_next_ = 0;
    return verdict;
  }
  if (verdict.label != next_label_) num_next_ = 0;
  next_label_ = verdict.label;
  ++num_next_;
  // A staircase has been confirmed by its tracker, and its regions must agree with it at once.
  const bool step_before = region_->staircase_id.has_value();
  const bool free_to_change = told == TerrainLabel::kUnknown || told == TerrainLabel::kRamp || step_before;
  const bool at_once = free_to_change && verdict.label != TerrainLabel::kRamp;
  if (at_once || num_next_ >= frames_to_change) {
    num_next_ = 0;
    return verdict;
  }
  if (step_before || told == TerrainLabel::kUnknown) return undecided;
  Verdict held;
  held.label = told;
  held.confidence = region_->confidence;
  held.evidence = evidence_;
  return held;
}

void RegionRecord::Tell(const PolygonPtr& polygon_ptr, const Verdict& verdict, const InStaircase* stairs) {
  // A confidence that moves by less is not worth a message.
  constexpr double kConfidenceStep = 0.05;
  const Polygon& polygon = *polygon_ptr;
  const bool same_polygon = region_ && !OutOfDate(polygon_ptr);
  polygon_ = polygon_ptr;
  told_ = true;
  evidence_ = verdict.evidence;
  const char* const why = WhyUndecided(verdict.evidence.rule);
  const std::optional<std::int64_t> staircase_id = stairs ? std::optional(stairs->id) : std::nullopt;
  const std::optional<int> step_index = stairs ? std::optional(stairs->place.step_index) : std::nullopt;
  std::optional<std::vector<RegionEdge>> edges = std::exchange(new_edges, std::nullopt);
  const bool same_edges = region_ && (!edges || *edges == region_->edges);
  if (same_polygon && region_->label == verdict.label && region_->why == why &&
      region_->staircase_id == staircase_id && region_->step_index == step_index && same_edges &&
      std::abs(region_->confidence - verdict.confidence) < kConfidenceStep)
    return;
  auto region = std::make_shared<TerrainRegion>();
  region->id = polygon.id;
  region->revision = region_ ? region_->revision + 1 : polygon.revision;
  region->label = verdict.label;
  region->confidence = verdict.confidence;
  region->why = why;
  region->plane_world = polygon.plane_world;
  region->plane_covariance = polygon.plane_covariance;
  region->centroid_world = polygon.centroid_world;
  region->rms_m = polygon.rms_m;
  region->area_m2 = polygon.area_m2;
  region->outline_world = polygon.outline_world;
  region->holes_world = polygon.holes_world;
  // Copied, not moved, so that regions hold no more room than they need.
  if (edges)
    region->edges = *edges;
  else if (region_)
    region->edges = region_->edges;
  region->support = polygon.support;
  region->num_observations = polygon.num_observations;
  region->first_seen = polygon.first_seen;
  region->last_seen = polygon.last_seen;
  if (region_) {
    region->num_observations = std::max(region->num_observations, region_->num_observations + num_seen_);
    region->last_seen = std::max(region->last_seen, region_->last_seen);
  }
  num_seen_ = 0;
  region->staircase_id = staircase_id;
  region->step_index = step_index;
  region_ = std::move(region);
}

void RegionRecord::See(Timestamp t_capture) {
  constexpr std::chrono::milliseconds kTellSeen{200};
  ++num_seen_;
  if (t_capture - region_->last_seen < kTellSeen) return;
  auto region = std::make_shared<TerrainRegion>(*region_);
  region->num_observations += std::exchange(num_seen_, 0);
  region->last_seen = t_capture;
  region_ = std::move(region);
}

}  // namespace terrace
