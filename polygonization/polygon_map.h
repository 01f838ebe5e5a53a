// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "core/time.h"
#include "polygonization/polygon.h"

namespace terrace {

/// The polygons of the whole map by their ids, and when each was last in view: what a new look at a polygon
/// that it does not change advances without making a new revision.
class PolygonMap {
 public:
  struct Entry {
    PolygonPtr polygon;
    int num_observations = 0;  ///< frames that showed it, changed or not
    Timestamp last_seen;       ///< the last one of them
  };
  using Entries = std::map<PolygonId, Entry>;

  /// Null when there is none with this id.
  const Entry* FindEntry(PolygonId id) const {
    const auto found = entries_.find(id);
    return found == entries_.end() ? nullptr : &found->second;
  }
  PolygonPtr Find(PolygonId id) const {
    const Entry* entry = FindEntry(id);
    return entry ? entry->polygon : nullptr;
  }
  /// Pairs of id and entry, ascending by id.
  Entries::const_iterator begin() const { return entries_.begin(); }
  Entries::const_iterator end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }
  bool empty() const { return entries_.empty(); }

  /// A new polygon, or a new revision in the place of the one before.
  void Put(PolygonPtr polygon) {
    Entry& entry = entries_[polygon->id];
    bytes_ += BytesOf(*polygon) - (entry.polygon ? BytesOf(*entry.polygon) : 0);
    entry = {polygon, polygon->num_observations, polygon->last_seen};
  }
  void Erase(PolygonId id) {
    const auto found = entries_.find(id);
    if (found == entries_.end()) return;
    bytes_ -= BytesOf(*found->second.polygon);
    entries_.erase(found);
  }
  /// It was in view again.
  void Seen(PolygonId id, Timestamp t_capture) {
    Entry& entry = entries_.at(id);
    ++entry.num_observations;
    entry.last_seen = t_capture;
  }

  /// Heap of the polygons; counted as they come and go.
  std::int64_t memory_bytes() const { return bytes_; }

 private:
  static std::int64_t BytesOf(const Polygon& polygon) {
    std::size_t bytes = sizeof(Polygon) + polygon.outline_world.capacity() * sizeof(Eigen::Vector3d);
    for (const Ring& hole : polygon.holes_world) bytes += hole.capacity() * sizeof(Eigen::Vector3d);
    return static_cast<std::int64_t>(bytes);
  }

  Entries entries_;
  std::int64_t bytes_ = 0;
};

}  // namespace terrace
