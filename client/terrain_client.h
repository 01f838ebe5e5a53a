// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>

#include "client/terrain_follower.h"
#include "core/terrain_map.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// The daemon's map in a planner's program: listens on an LCM, and asks the daemon for a snapshot when one is
/// needed. Works inside lcm.handle(), in the caller's thread. `lcm` must outlive it.
class TerrainClient {
 public:
  explicit TerrainClient(lcm::LCM* lcm, const ChannelConfig& channels = {});
  ~TerrainClient();
  TerrainClient(const TerrainClient&) = delete;
  TerrainClient& operator=(const TerrainClient&) = delete;

  /// The map in its newest state; null before the first one has arrived. It never changes: keep it as long as
  /// you like.
  const TerrainMapPtr& map() const { return follower_.map(); }

  const TerrainFollower& follower() const { return follower_; }

 private:
  void OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void AskForSnapshot();

  lcm::LCM* const lcm_;
  const std::string command_channel_;
  lcm::Subscription* subscription_ = nullptr;
  TerrainFollower follower_;
  std::optional<std::chrono::steady_clock::time_point> asked_;
  std::int64_t num_requests_ = 0;
};

}  // namespace terrace
