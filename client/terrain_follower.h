// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>

#include "core/terrain_map.h"

namespace terrace {

/// Keeps a copy of the daemon's map in step with its messages: snapshots and deltas, in parts, late, doubled,
/// lost or in any order; and says what to ask the daemon for. Knows no bus and no clock; TerrainClient gives
/// it both.
class TerrainFollower {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Takes a terrain_v1_t as it came; true when there is another map: a new state, or the same one seen
  /// again. Bytes that are no such message are counted and change nothing.
  bool Receive(const void* data, std::size_t size, Time now = std::chrono::steady_clock::now());

  /// The map in its newest state; null before the first snapshot. Shared and never edited.
  const TerrainMapPtr& map() const { return map_; }

  /// False when there is no map, or when there is a newer state than map() as far as anybody has said.
  bool in_step() const;

  /// What to ask for now; none when nothing is missing, is probably still under way, or was just asked for.
  /// To be called every 10 ms or so.
  std::optional<terrain_repair_v1_t> TakeRepair(Time now);

  std::int64_t num_bad_messages() const { return num_bad_messages_; }

 private:
  using Part = std::shared_ptr<const terrain_v1_t>;
  /// What leads to one state: a snapshot or a delta, whole or still in parts.
  struct Step {
    std::int64_t map_id = 0;
    std::int64_t seq = 0;
    std::int64_t base_seq = 0;
    bool snapshot = false;
    std::map<std::int32_t, Part> parts;
    std::int32_t num_parts = 0;  // 0: not known yet
    std::size_t num_bytes = 0;
    Time t_last;  // when its newest part came

    bool complete() const { return num_parts > 0 && parts.size() == static_cast<std::size_t>(num_parts); }
  };

  bool IsOutdated(std::int64_t map_id, std::int64_t seq) const;
  void HearOf(const terrain_v1_t& message, Time now);
  bool AddPart(Part part, std::size_t size, Time now);
  bool ApplyAll();
  std::list<Step>::iterator FindApplicable();
  bool Apply(const Step& step);
  void MakeMap(const TerrainMap& head);
  bool SeeAgain(const terrain_v1_t& message);
  void Forget();
  void Retire(std::int64_t map_id);
  bool ShouldAsk(Time now) const;

  TerrainMapPtr map_;
  std::map<std::int64_t, std::shared_ptr<const TerrainRegion>> regions_;
  std::map<std::int64_t, Staircase> staircases_;  // without region_ids
  std::list<Step> pending_;                       // in order of arrival
  std::size_t pending_bytes_ = 0;
  std::map<std::int64_t, std::int64_t> retired_;  // map_id -> number of the message when it was replaced
  std::int64_t newest_map_id_ = 0;                // that anybody has spoken of; 0: none
  std::int64_t newest_seq_ = -1;
  Time t_newest_;  // when it was first heard of
  std::optional<Time> t_asked_;
  Time t_heard_;
  std::int64_t num_messages_ = 0;
  std::int64_t num_bad_messages_ = 0;
};

}  // namespace terrace
