// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "core/check.h"
#include "core/landmark_sightings.h"
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

const char* Name(TerrainLabel label) { return NameIn(kLabelNames, label); }

std::optional<TerrainLabel> TerrainLabelFromName(const std::string& name) {
  return ValueIn<TerrainLabel>(kLabelNames, name);
}

const char* Name(EdgeKind kind) { return NameIn(kEdgeKindNames, kind); }

std::optional<EdgeKind> EdgeKindFromName(const std::string& name) {
  return ValueIn<EdgeKind>(kEdgeKindNames, name);
}

}  // namespace terrace
