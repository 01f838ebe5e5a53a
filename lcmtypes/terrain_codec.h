// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <terrace/terrain_v1_t.hpp>

#include "core/map_difference.h"
#include "core/terrain_map.h"

namespace terrace {

/// With LCM's own header and those of UDP and IP it fits one Ethernet packet: a part is lost with one packet
/// and no other.
inline constexpr std::size_t kMaxTerrainMessageBytes = 1400;

/// What every part says beside regions and staircases. `kind`, `base_seq`, `part` and `n_parts` stay 0.
terrain_v1_t TerrainHead(const TerrainMap& map, const std::optional<Eigen::Isometry3d>& T_body_left);
/// The map that such a head tells of, without regions and staircases; none when a value cannot be meant.
std::optional<TerrainMap> FromMessage(const terrain_v1_t& message);

/// Fills the messages of one snapshot or delta one after the other, each up to its size. A large region is
/// cut into pieces.
class TerrainParts {
 public:
  /// @param head  of every part, with `kind` and `base_seq`
  explicit TerrainParts(terrain_v1_t head, std::size_t max_bytes = kMaxTerrainMessageBytes);

  void Remove(std::int64_t region_id);
  void RemoveStaircase(std::int64_t staircase_id);
  void Add(const Staircase& staircase);
  void Add(const TerrainRegion& region, const Gravity& gravity);

  /// Those that are full; their `n_parts` is not known yet.
  std::vector<terrain_v1_t> TakeFull();
  /// All that have not been taken, at least one.
  std::vector<terrain_v1_t> Finish();

 private:
  terrain_v1_t& PartWithRoomFor(std::size_t bytes);

  const std::size_t max_bytes_;
  const terrain_v1_t blank_;
  const std::size_t blank_bytes_;
  std::vector<terrain_v1_t> parts_;  // not taken yet; the last one is being filled
  std::size_t bytes_;                // of the last one
  std::int32_t num_taken_ = 0;
};

/// The whole map.
std::vector<terrain_v1_t> SnapshotMessages(const TerrainMap& map,
                                           std::size_t max_bytes = kMaxTerrainMessageBytes);
/// What must change to turn the state `base_seq` into `map`; `difference` between the two.
std::vector<terrain_v1_t> DeltaMessages(std::int64_t base_seq, const TerrainMap& map,
                                        const MapDifference& difference,
                                        const std::optional<Eigen::Isometry3d>& T_body_left,
                                        std::size_t max_bytes = kMaxTerrainMessageBytes);
std::vector<terrain_v1_t> DeltaMessages(const TerrainMap& base, const TerrainMap& map,
                                        std::size_t max_bytes = kMaxTerrainMessageBytes);

/// A region that was seen again.
struct SeenRegion {
  std::int64_t id = 0;
  Timestamp last_seen;
};
/// Says that the state of `map` stands, and what of it was seen again; one message or more.
std::vector<terrain_v1_t> SeenMessages(const TerrainMap& map,
                                       const std::optional<Eigen::Isometry3d>& T_body_left,
                                       std::span<const SeenRegion> seen,
                                       std::size_t max_bytes = kMaxTerrainMessageBytes);
/// What a message says was seen again.
std::vector<SeenRegion> SeenIn(const terrain_v1_t& message);

}  // namespace terrace
