// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <vector>

#include <terrace/terrain_v1_t.hpp>

#include "core/terrain_map.h"

namespace terrace {

/// Keeps a copy of the daemon's map in step with its messages: snapshots and deltas, in parts, late, doubled,
/// lost or in any order. What was lost is made good by the next snapshot. Knows no bus; TerrainClient feeds
/// one from LCM.
class TerrainFollower {
 public:
  /// Takes a terrain_v1_t as it came; true when the map has a new state. Bytes that are no such message are
  /// counted and change nothing.
  bool Receive(const void* data, std::size_t size);

  /// The map in its newest state; null before the first snapshot. Shared and never edited.
  const TerrainMapPtr& map() const { return map_; }

  /// True when only a snapshot helps: there is no map yet, or messages were lost.
  bool needs_snapshot() const;

  std::int64_t num_bad_messages() const { return num_bad_messages_; }

 private:
  /// What leads to one state: a snapshot or a delta, whole or still in parts.
  struct Step {
    std::int64_t map_id = 0;
    std::int64_t seq = 0;
    std::int64_t base_seq = 0;
    bool snapshot = false;
    std::vector<std::shared_ptr<const terrain_v1_t>> parts;  // null: not yet in
    std::size_t num_missing = 0;
    std::size_t num_bytes = 0;
  };

  bool IsOutdated(std::int64_t map_id, std::int64_t seq) const;
  bool AddPart(std::shared_ptr<const terrain_v1_t> part, std::size_t size);
  bool ApplyAll();
  std::list<Step>::iterator FindApplicable();
  bool Apply(const Step& step);
  void Forget();
  void Retire(std::int64_t map_id);

  TerrainMapPtr map_;
  std::map<std::int64_t, std::shared_ptr<const TerrainRegion>> regions_;
  std::list<Step> pending_;  // in order of arrival
  std::size_t pending_bytes_ = 0;
  std::map<std::int64_t, std::int64_t> retired_;  // map_id -> number of the message when it was replaced
  std::int64_t num_messages_ = 0;
  std::int64_t num_bad_messages_ = 0;
};

}  // namespace terrace
