// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <lcm/lcm-cpp.hpp>

#include "client/client_health.h"
#include "client/pose_history.h"
#include "client/terrain_follower.h"
#include "core/body_pose.h"
#include "core/map_difference.h"
#include "core/map_transform.h"
#include "core/status.h"
#include "core/terrain_map.h"
#include "core/time.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// The daemon's map and pose in a planner's program: listens on an LCM inside lcm.handle(), in the caller's
/// thread, and asks the daemon for what is missing from a thread of its own, also when nothing has been heard
/// at all. `lcm` must outlive it. What is const may be called from any thread.
class TerrainClient {
 public:
  explicit TerrainClient(lcm::LCM* lcm, const ChannelConfig& channels = {});
  ~TerrainClient();
  TerrainClient(const TerrainClient&) = delete;
  TerrainClient& operator=(const TerrainClient&) = delete;

  /// A map that was saved, a .terrace file. Throws FileError with place and reason.
  static TerrainMapPtr LoadMap(const std::filesystem::path& file);
  /// The map as it was at a moment, out of a log of the bus; see MapFromLog().
  static TerrainMapPtr FromLog(const std::filesystem::path& log, Timestamp t,
                               const ChannelConfig& channels = {});

  /// The map in its newest state; null before the first one has arrived. It never changes: keep it as long as
  /// you like.
  TerrainMapPtr map() const;
  /// False when there is no map yet, or a newer one that has not arrived whole.
  bool in_step() const;

  /// Called inside lcm.handle() whenever the map has changed, or was seen again: with what turned the map
  /// before into the new one. When another map begins (`map_id`), everything is removed, then everything
  /// added, in two calls, the first with a null map.
  using ChangeHandler = std::function<void(const MapDifference& change, const TerrainMapPtr& map)>;
  void OnChange(ChangeHandler handler);

  /// Where the body was at a moment of the last ten seconds; see PoseHistory::At().
  std::optional<BodyPose> BodyPoseAt(Timestamp t) const;
  std::optional<BodyPose> newest_pose() const;

  /// Where a map that the daemon has loaded lies in the world, or why that is not known; none: the daemon has
  /// said nothing of one.
  std::optional<MapTransform> map_transform() const;

  ClientHealth Health() const;
  /// Messages on the terrain's channel that were no terrain, or could not be meant.
  std::int64_t num_bad_messages() const;

 private:
  void OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnPose(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnMapTransform(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnStatus(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void Subscribe(const ChannelConfig& channels);
  void TellChange(const TerrainMapPtr& before, const TerrainMapPtr& map) const;
  void AskUntilTheEnd();

  lcm::LCM* const lcm_;
  const std::string repair_channel_;
  std::vector<lcm::Subscription*> subscriptions_;
  ChangeHandler on_change_;   // only used inside lcm.handle()
  mutable std::mutex mutex_;  // of everything below
  TerrainFollower follower_;
  PoseHistory poses_;
  std::optional<Status> status_;
  std::optional<MapTransform> map_transform_;
  std::optional<std::chrono::steady_clock::time_point> t_heard_;
  std::int64_t num_repairs_ = 0;
  std::int64_t num_bad_pose_ = 0;
  std::int64_t num_bad_status_ = 0;
  bool end_ = false;
  std::condition_variable end_changed_;
  std::thread asking_;  // last: it uses everything above
};

}  // namespace terrace
