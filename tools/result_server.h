// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>

#include <lcm/lcm-cpp.hpp>

#include "core/terrain_map.h"
#include "daemon/terrain_publisher.h"
#include "lcmtypes/channels.h"
#include "results/replay_result.h"

namespace terrace {

/// The map of a finished result, as the daemon had it after the last frame and with the last pose.
TerrainMapPtr ServedMap(const ReplayResult& result);
/// Of a folder that a replay wrote, or of a .terrace file.
TerrainMapPtr MapToServe(const std::filesystem::path& result);

/// Publishes a finished map, whose newest image gave the pose, as the daemon does while nothing changes: the
/// terrain, also to those who come late, the last pose ten times a second and the status once a second. Time
/// of day in what it sends is the recording's.
class ResultServer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Answers repairs inside lcm->handle(). `lcm` must outlive it.
  /// @param map  not null; its T_world_left is the pose that is sent
  ResultServer(lcm::LCM* lcm, TerrainMapPtr map, const ChannelConfig& channels = {});
  ~ResultServer();
  ResultServer(const ResultServer&) = delete;
  ResultServer& operator=(const ResultServer&) = delete;

  /// Sends what is due. To be called every 20 ms or so.
  void Tick(Time now);

 private:
  void OnRepair(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void PublishStatus();

  lcm::LCM* const lcm_;
  const ChannelConfig channels_;
  const TerrainMapPtr map_;
  TerrainPublisher publisher_;
  PoseEstimate pose_;
  lcm::Subscription* subscription_ = nullptr;
  std::int64_t num_statuses_ = 0;
  std::optional<Time> t_pose_;
  std::optional<Time> t_status_;
};

}  // namespace terrace
