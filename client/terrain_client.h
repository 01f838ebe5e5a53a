// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include <lcm/lcm-cpp.hpp>

#include "client/terrain_follower.h"
#include "core/terrain_map.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// The daemon's map in a planner's program: listens on an LCM inside lcm.handle(), in the caller's thread,
/// and asks the daemon for what is missing from a thread of its own, also when nothing has been heard at all.
/// `lcm` must outlive it. map() and in_step() may be called from any thread.
class TerrainClient {
 public:
  explicit TerrainClient(lcm::LCM* lcm, const ChannelConfig& channels = {});
  ~TerrainClient();
  TerrainClient(const TerrainClient&) = delete;
  TerrainClient& operator=(const TerrainClient&) = delete;

  /// The map in its newest state; null before the first one has arrived. It never changes: keep it as long as
  /// you like.
  TerrainMapPtr map() const;
  /// False when there is no map yet, or a newer one that has not arrived whole.
  bool in_step() const;
  /// Messages on the terrain's channel that were no terrain, or could not be meant.
  std::int64_t num_bad_messages() const;

 private:
  void OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void AskUntilTheEnd();

  lcm::LCM* const lcm_;
  const std::string repair_channel_;
  lcm::Subscription* subscription_ = nullptr;
  mutable std::mutex mutex_;
  TerrainFollower follower_;
  bool end_ = false;
  std::condition_variable end_changed_;
  std::thread asking_;  // last: it uses everything above
};

}  // namespace terrace
