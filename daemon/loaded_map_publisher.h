// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include <lcm/lcm-cpp.hpp>
#include <terrace/terrain_repair_v1_t.hpp>

#include "core/terrain_map.h"
#include "daemon/loaded_map.h"
#include "daemon/terrain_publisher.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// Says once a second, and when another map begins, where a loaded map lies, and publishes it by itself while
/// that is not known. `lcm` must outlive it.
class LoadedMapPublisher {
 public:
  LoadedMapPublisher(lcm::LCM* lcm, const ChannelConfig& channels, double snapshot_period_s);

  /// Sends what is due. To be called every 20 ms or so, in a replay with every frame.
  /// @param terrain_map_id  of the terrain that is published
  void Tick(const LoadedMap& loaded, std::int64_t terrain_map_id);
  /// Sends a subscriber what it lacks of the map that stands by itself; false: it is not about that one.
  bool Answer(const terrain_repair_v1_t& repair);
  /// Now, due or not.
  void SayWhereItLies(const LoadedMap& loaded, std::int64_t terrain_map_id);

 private:
  lcm::LCM* const lcm_;
  ChannelConfig channels_;  // terrain goes where loaded maps go
  const double snapshot_period_s_;
  TerrainMapPtr alone_;
  std::optional<TerrainPublisher> publisher_;
  std::chrono::steady_clock::time_point due_;
  std::int64_t said_of_map_id_ = 0;
};

}  // namespace terrace
