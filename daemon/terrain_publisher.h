// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <lcm/lcm-cpp.hpp>

#include "core/pose_estimate.h"
#include "core/status.h"
#include "core/terrain_map.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// Sends what the mapper knows over LCM: the pose of the body and the motion of the camera for every frame,
/// the terrain whenever it has changed (a snapshot first, when asked, and every so often; deltas otherwise),
/// and the status. Every function may be called from any thread. `lcm` must outlive it.
class TerrainPublisher {
 public:
  /// @param T_body_left  none: body is taken as the camera with x forward, y left, z up
  TerrainPublisher(lcm::LCM* lcm, ChannelConfig channels, std::optional<Eigen::Isometry3d> T_body_left,
                   double snapshot_period_s);

  /// The pose of one frame; does not wait for terrain that is being sent.
  void PublishPose(const PoseEstimate& pose);
  /// The map as one frame left it: what has changed since the last one, and a snapshot when one is due.
  void PublishTerrain(const TerrainMapPtr& map);
  void Publish(const Status& status);
  /// Sends the map again, whole; false when there is none yet.
  bool SendSnapshot();

  /// Messages that LCM refused to send.
  std::int64_t num_failures() const;

 private:
  template <typename Message>
  void Send(const std::string& channel, const Message& message);
  template <typename Messages>
  void SendTerrain(Messages messages);

  lcm::LCM* const lcm_;
  const ChannelConfig channels_;
  const Eigen::Isometry3d T_body_left_;
  const std::chrono::nanoseconds snapshot_period_;
  /// Map ids count from the start of the daemon; this makes them differ from those of an earlier one.
  const std::int64_t first_map_id_;
  std::mutex pose_mutex_;  // of the pose's channels
  mutable std::mutex mutex_;
  std::optional<Timestamp> t_pose_;
  TerrainMapPtr sent_;
  Timestamp t_snapshot_;
  std::atomic<std::int64_t> num_failures_{0};
};

}  // namespace terrace
