// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <lcm/lcm-cpp.hpp>
#include <terrace/terrain_repair_v1_t.hpp>

#include "core/map_change.h"
#include "core/pose_estimate.h"
#include "core/status.h"
#include "core/terrain_map.h"
#include "daemon/terrain_sender.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// T_body_left where no body is known: at the camera, x forward, y left, z up.
Eigen::Isometry3d LevelBody();

/// Publishes what leaves the daemon on LCM: the pose three times over (body, body with all that is known of
/// it, motion of the camera) and the terrain (see TerrainSender). Every function may be called from any
/// thread. `lcm` must outlive it.
class TerrainPublisher {
 public:
  /// @param T_body_left  none: body is taken as the camera with x forward, y left, z up
  TerrainPublisher(lcm::LCM* lcm, ChannelConfig channels, std::optional<Eigen::Isometry3d> T_body_left,
                   double snapshot_period_s);

  /// The pose of one frame; does not wait for terrain that is being sent.
  void PublishPose(const PoseEstimate& pose);
  /// What one frame did to the map.
  void PublishTerrain(const MapChange& change);
  /// Sends a subscriber what it lacks.
  void Answer(const terrain_repair_v1_t& repair);
  /// Sends what is due by the clock. To be called every 20 ms or so.
  void Tick();
  /// Sends the map again, whole, spread over the next ticks; false when there is none yet.
  bool SendSnapshot();
  /// True as long as parts of a snapshot are still to come.
  bool sending_snapshot() const;

  /// Of the map that is out; 0: there is none yet.
  std::int64_t map_id() const { return map_id_; }
  /// Names the map that is out in a status.
  void Describe(Status* status) const;

 private:
  void Send(const std::vector<TerrainSender::Packet>& packets);

  lcm::LCM* const lcm_;
  const ChannelConfig channels_;
  const Eigen::Isometry3d T_body_left_;
  std::mutex pose_mutex_;  // of what only poses use
  std::optional<Timestamp> t_pose_;
  std::atomic<std::int64_t> map_id_{0};  // that is out
  mutable std::mutex mutex_;             // of the rest
  TerrainSender sender_;
};

}  // namespace terrace
