// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "core/check.h"
#include "core/explanation.h"
#include "core/landmark_sightings.h"
#include "core/map_transform.h"
#include "core/pose_estimate.h"
#include "core/reason_code.h"
#include "core/status.h"
#include "core/terrain_map.h"

namespace terrace {
namespace {

template <typename Enum, std::size_t N>
const char* NameIn(const std::array<const char*, N>& names, Enum value) {
  const auto index = static_cast<std::size_t>(value);
  TERRACE_CHECK(index < N, index);
  return names[index];
}

constexpr std::array<const char*, kNumTerrainLabels> kLabelNames = {
    "unknown", "walkway", "ramp", "stair_tread", "stair_riser", "wall", "obstacle", "level"};
constexpr std::array<const char*, kNumEdgeKinds> kEdgeKindNames = {"limit", "drop", "rise", "joins"};
constexpr std::array<const char*, kNumLabelRules> kLabelRuleNames = {"not_looked_at",
                                                                     "step",
                                                                     "inferred_step",
                                                                     "reachable_ground",
                                                                     "continues_ground",
                                                                     "reachable_slope",
                                                                     "stands_on_ground",
                                                                     "out_of_reach",
                                                                     "high_face",
                                                                     "face_out_of_view",
                                                                     "continues_wall",
                                                                     "face_with_top",
                                                                     "face_ends",
                                                                     "steep_on_ground",
                                                                     "too_small",
                                                                     "top_not_seen",
                                                                     "slope_not_resolved",
                                                                     "slope_not_plane",
                                                                     "slope_just_seen",
                                                                     "slope_out_of_reach",
                                                                     "slope_too_small",
                                                                     "slope_not_known",
                                                                     "steep_foot_not_known",
                                                                     "too_small_to_walk_on",
                                                                     "faces_down"};

template <typename Enum, std::size_t N>
std::optional<Enum> ValueIn(const std::array<const char*, N>& names, const std::string& name) {
  for (std::size_t i = 0; i < N; ++i) {
    if (name == names[i]) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

}  // namespace

const char* Name(TrackingStatus status) {
  return NameIn(std::array<const char*, 3>{"tracking", "bridging", "lost"}, status);
}

const char* Name(GravitySource source) {
  return NameIn(std::array<const char*, 5>{"imu", "attitude", "mounting", "plane", "assumed"}, source);
}

const char* Name(LandmarkFate fate) {
  return NameIn(std::array<const char*, 3>{"agrees", "rejected", "created"}, fate);
}

const char* Name(ReasonCode code) {
  return NameIn(
      std::array<const char*, kNumReasonCodes>{"none", "other", "unreadable images", "few features",
                                               "not found again", "ambiguous motion", "no images",
                                               "no calibration", "bad calibration", "input trouble"},
      code);
}

const char* Name(DaemonState state) {
  return NameIn(std::array<const char*, 7>{"starting", "running", "degraded", "paused", "no input",
                                           "no calibration", "stopping"},
                state);
}

const char* Name(MapPlacing placing) {
  return NameIn(std::array<const char*, kNumMapPlacings>{"not_found", "given", "confirmed", "recognised"},
                placing);
}

const char* Name(TerrainLabel label) { return NameIn(kLabelNames, label); }

std::optional<TerrainLabel> TerrainLabelFromName(const std::string& name) {
  return ValueIn<TerrainLabel>(kLabelNames, name);
}

const char* Name(EdgeKind kind) { return NameIn(kEdgeKindNames, kind); }

std::optional<EdgeKind> EdgeKindFromName(const std::string& name) {
  return ValueIn<EdgeKind>(kEdgeKindNames, name);
}

const char* Name(LabelRule rule) { return NameIn(kLabelRuleNames, rule); }

std::optional<LabelRule> LabelRuleFromName(const std::string& name) {
  return ValueIn<LabelRule>(kLabelRuleNames, name);
}

}  // namespace terrace
