// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/loaded_staircases.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace terrace {
namespace {

/// How many risers of the loaded flight lie below the first one that was seen (negative: the seen one begins
/// lower); none: they are two flights.
std::optional<int> RisersBelow(const Staircase& loaded, const Staircase& seen) {
  constexpr double kMaxFlightsApart_rad = 20.0 * M_PI / 180.0;
  constexpr double kMaxRiserApart_m = 0.03;
  if (loaded.direction_up_world.dot(seen.direction_up_world) < std::cos(kMaxFlightsApart_rad))
    return std::nullopt;
  if (std::abs(loaded.riser_m - seen.riser_m) > kMaxRiserApart_m) return std::nullopt;
  const Eigen::Vector3d between = seen.base_world() - loaded.base_world();
  const int below = static_cast<int>(std::lround(between.z() / loaded.riser_m));
  if (below >= loaded.num_risers || below + seen.num_risers <= 0) return std::nullopt;
  const double along_m = between.dot(loaded.direction_up_world);
  const double aside_m = (between - along_m * loaded.direction_up_world).head<2>().norm();
  // Half a tread beside the law is another flight, or another step of this one: neither may be joined.
  const bool in_line = std::abs(along_m - below * loaded.tread_m) < 0.5 * loaded.tread_m;
  return in_line && aside_m < 0.5 * (loaded.width_m + seen.width_m) ? std::optional(below) : std::nullopt;
}

/// Both flights as one, with the ends of whichever reaches further.
Staircase Union(const Staircase& loaded, const Staircase& seen, int below) {
  // The law of the one that shows more steps.
  Staircase flight = seen.num_risers >= loaded.num_risers ? seen : loaded;
  flight.id = loaded.id;
  flight.last_seen = std::max(loaded.last_seen, seen.last_seen);
  flight.confidence = std::max(loaded.confidence, seen.confidence);
  const Staircase& lower = below < 0 ? seen : loaded;
  const Staircase& upper = below + seen.num_risers > loaded.num_risers ? seen : loaded;
  flight.foot_edge_world = lower.foot_edge_world;
  flight.head_edge_world = upper.head_edge_world;
  const int num_risers = std::max(loaded.num_risers, below + seen.num_risers) - std::min(0, below);
  flight.num_treads += num_risers - flight.num_risers;
  flight.num_risers = num_risers;
  return flight;
}

}  // namespace

JoinedStaircases Join(const std::vector<Staircase>& loaded_world, const std::vector<Staircase>& seen) {
  JoinedStaircases joined;
  std::vector<bool> taken(seen.size(), false);
  for (const Staircase& loaded : loaded_world) {
    Staircase flight = loaded;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const std::optional<int> below = taken[i] ? std::nullopt : RisersBelow(loaded, seen[i]);
      if (!below) continue;
      taken[i] = true;
      flight = Union(loaded, seen[i], *below);
      const int lowest = std::min(0, *below);
      joined.places[seen[i].id] = {loaded.id, *below - lowest};
      if (lowest < 0) joined.places[loaded.id] = {loaded.id, -lowest};
      break;
    }
    flight.region_ids.clear();
    joined.staircases.push_back(std::move(flight));
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (taken[i]) continue;
    joined.staircases.push_back(seen[i]);
    joined.staircases.back().region_ids.clear();
  }
  return joined;
}

}  // namespace terrace
