// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>

#include "core/map_change.h"
#include "core/terrain_map.h"
#include "lcmtypes/terrain_codec.h"

namespace terrace {

/// Turns the states of a map into messages, and answers what subscribers lack of them: each state as a delta,
/// snapshots now and then and when nothing else helps, spread over time with what is near the robot first,
/// and a few words when nothing changes. Knows no bus and no clock; every function returns what is to be sent
/// now. client/terrain_follower.h is the other end.
class TerrainSender {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Bytes = std::vector<std::uint8_t>;
  /// An encoded terrain_v1_t.
  using Packet = std::shared_ptr<const Bytes>;

  /// @param first_map_id  is added to the maps' own ids
  TerrainSender(std::optional<Eigen::Isometry3d> T_body_left, std::chrono::nanoseconds snapshot_period,
                std::int64_t first_map_id);

  /// A map came out of a frame, changed or not. Where the change does not start from the map that was sent
  /// last, the two maps are compared whole.
  std::vector<Packet> Update(const MapChange& change, Time now);
  /// What a subscriber lacks.
  std::vector<Packet> Answer(const terrain_repair_v1_t& repair, Time now);
  /// What is due by the clock. To be called every 20 ms or so.
  std::vector<Packet> Tick(Time now);
  /// Lets a snapshot begin with the next tick; false when there is no map yet.
  bool RequestSnapshot();

  bool sending_snapshot() const { return snapshot_.has_value(); }
  /// As it is sent; 0: there is no map yet.
  std::int64_t map_id() const { return map_ ? map_->map_id + first_map_id_ : 0; }
  std::int64_t seq() const { return map_ ? map_->seq : 0; }

 private:
  struct SentPart {
    Packet packet;
    Time t_sent;
  };
  /// A snapshot or delta as it was sent, for those who lost some of it.
  struct SentStep {
    std::int8_t kind = terrain_v1_t::DELTA;
    std::int64_t base_seq = 0;
    std::int64_t seq = 0;
    std::vector<SentPart> parts;
    bool complete = true;
  };
  /// A snapshot that is being sent.
  struct Snapshot {
    TerrainMapPtr map;
    std::vector<const TerrainRegion*> near_first;
    std::size_t next = 0;
    TerrainParts parts;
    Time t_advanced;
  };

  void SendDelta(const MapChange& change, Time now, std::vector<Packet>* out);
  void BeginSnapshot(Time now);
  void AdvanceSnapshot(Time now, std::vector<Packet>* out);
  void Announce(Time now, std::vector<Packet>* out);
  void NoteSeen(const TerrainMap& map, const std::vector<std::int64_t>& seen);
  terrain_v1_t Head(const TerrainMap& map, std::int8_t kind) const;
  void Record(const std::vector<terrain_v1_t>& messages, SentStep* step, Time now, std::vector<Packet>* out);
  void ForgetOldSteps();
  void SendAgain(SentStep* step, const repair_step_v1_t* lacks, Time now, std::vector<Packet>* out);
  SentStep* NewestSnapshot();
  bool WorthDeltasSince(std::int64_t seq) const;

  const std::optional<Eigen::Isometry3d> T_body_left_;
  const std::chrono::nanoseconds snapshot_period_;
  const std::int64_t first_map_id_;
  TerrainMapPtr map_;
  std::deque<SentStep> steps_;  // of this map, in order of sending
  std::size_t steps_bytes_ = 0;
  std::size_t snapshot_bytes_ = 0;  // of the last one that was sent whole
  std::optional<Snapshot> snapshot_;
  bool snapshot_wanted_ = false;
  Time t_snapshot_;        // when the last one began
  Time t_announced_;       // when anybody could last hear of the newest state
  int num_announced_ = 0;  // times, since that state
  Time t_seen_list_;
  std::map<std::int64_t, Timestamp> seen_;  // since the last list
};

}  // namespace terrace
