// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/terrain_map.h"

namespace terrace {

/// The rule by which a region has its label.
enum class LabelRule {
  kNotLookedAt,        ///< nothing was decided: it left its staircase while it was far away
  kStep,               ///< a tread or riser of a staircase
  kInferredStep,       ///< the same, not seen: the law of the staircase demands it
  kReachableGround,    ///< level, large and reachable
  kContinuesGround,    ///< level, and goes on where reachable ground ends
  kReachableSlope,     ///< a plane, inclined, large and reachable
  kStandsOnGround,     ///< the top of something that stands on lower ground
  kOutOfReach,         ///< level, nothing lower beside it, not reachable
  kHighFace,           ///< upright, and higher than an obstacle
  kFaceOutOfView,      ///< upright, and ends where the view ended
  kContinuesWall,      ///< upright, in the plane of a wall
  kFaceWithTop,        ///< upright, with something level on its upper edge
  kFaceEnds,           ///< upright, and what lies above its top was seen
  kSteepOnGround,      ///< too steep to walk on, and stands on ground
  kTooSmall,           ///< too small to be decided
  kTopNotSeen,         ///< upright, never seen from near enough to know whether it ends
  kSlopeNotResolved,   ///< inclined, and steps may hide in its noise
  kSlopeNotPlane,      ///< inclined, and departs from its plane
  kSlopeJustSeen,      ///< it looks like a ramp, for fewer frames than that takes
  kSlopeOutOfReach,    ///< inclined and not reachable
  kSlopeTooSmall,      ///< inclined and too small to walk on
  kSlopeNotKnown,      ///< it may be level, but how it leans is not known
  kSteepFootNotKnown,  ///< too steep to walk on, nothing known of its foot
  kTooSmallToWalkOn,   ///< level and reachable, and too small
  kFacesDown,
};
inline constexpr int kNumLabelRules = 25;
const char* Name(LabelRule rule);  ///< "step", "reachable_ground", ...
std::optional<LabelRule> LabelRuleFromName(const std::string& name);

/// Another region to which the robot can step, or into which the ground goes on.
struct NeighborRegion {
  std::int64_t id = 0;
  bool joins = false;   ///< the same ground goes on; else there is a step between
  double step_m = 0.0;  ///< height of the neighbour over the region

  friend bool operator==(const NeighborRegion&, const NeighborRegion&) = default;
};

/// Why a region has its label: the numbers as they were when it was decided, and the same in words.
struct RegionExplanation {
  std::int64_t id = 0;
  TerrainLabel label = TerrainLabel::kUnknown;
  double confidence = 0.0;
  LabelRule rule = LabelRule::kNotLookedAt;
  double slope_rad = 0.0;  ///< from level by gravity, 0..pi
  double slope_sigma_rad = 0.0;
  double offset_sigma_m = 0.0;  ///< how well the plane is known along its normal
  double rms_m = 0.0;           ///< of its points about its plane
  double noise_m = 0.0;         ///< what the sensor adds to single points
  double area_m2 = 0.0;
  int num_observations = 0;
  std::optional<double> largest_square_m;  ///< edge, up to what a walkway must hold; supports only
  std::optional<double> nearest_view_m;    ///< least distance from which it was seen
  /// Lower steps than this would not show in it, seen as it was; what is inclined only.
  std::optional<double> lowest_step_m;
  /// Of a face: its top over the ground at its foot. Of a support: over the lower ground beside it.
  std::optional<double> height_m;
  std::optional<bool> large;               ///< alone or with what joins it; supports only
  std::optional<bool> reachable;           ///< from where the robot stands or stood; supports only
  std::optional<std::int64_t> decided_by;  ///< the wall or the ground that it continues
  std::optional<std::int64_t> staircase;   ///< that it is a step of
  std::optional<int> step_index;
  std::optional<TerrainLabel> by_itself;   ///< of a step: what it would be without its staircase
  std::optional<TerrainLabel> next_label;  ///< that the last frames gave it, too few of them to change it
  int num_next = 0;                        ///< frames in a row that did
  std::vector<NeighborRegion> neighbors;   ///< ascending by id
  std::string text;
};

/// Why there is a staircase.
struct StaircaseExplanation {
  std::int64_t id = 0;
  double confidence = 0.0;
  int num_risers = 0;
  int num_treads = 0;
  double riser_m = 0.0;
  double riser_sigma_m = 0.0;
  double tread_m = 0.0;
  double tread_sigma_m = 0.0;
  double pitch_rad = 0.0;
  std::vector<int> risers_seen;  ///< indices, ascending
  std::vector<int> treads_seen;
  std::optional<std::int64_t> foot_region;  ///< floor before the first riser
  std::optional<std::int64_t> head_region;  ///< landing above the last one
  int num_seen = 0;                         ///< steps that obeyed its law when it was last found
  int num_to_see = 0;                       ///< that could be seen from there
  bool seen_sharply = false;
  bool faces_tile = false;    ///< faces reach from one step to the next
  bool sides_agree = false;   ///< the steps have the same sides
  double height_rms_m = 0.0;  ///< of the steps about the law
  std::string text;
};

struct Explanations {
  std::vector<RegionExplanation> regions;        ///< ascending by id
  std::vector<StaircaseExplanation> staircases;  ///< ascending by id
};

}  // namespace terrace
