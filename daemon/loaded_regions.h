// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "client/region_shape.h"
#include "core/terrain_map.h"

namespace terrace {

/// The regions of a loaded map that lie in the world, less what has been seen since: where a new region shows
/// the same surface, it takes its place, and does not give it back. So the ground is never there twice, and
/// what is seen is newer than what is remembered.
class LoadedRegions {
 public:
  /// New ids begin behind the loaded ones, with room for pieces that loaded regions fall into.
  static constexpr std::int64_t kRoomForPieces = 1'000'000;

  /// @param regions_world  ascending by id
  explicit LoadedRegions(const std::vector<TerrainRegion>& regions_world);

  /// Takes away what a region that was seen shows of the same surfaces.
  void TakeAway(const TerrainRegion& seen);
  /// Whether most of an inferred region is one that was seen when the map was saved.
  bool Shows(const TerrainRegion& predicted) const;

  /// What is left, ascending by id.
  std::vector<std::shared_ptr<const TerrainRegion>> regions() const;
  /// Greater than all loaded ids and those of pieces.
  std::int64_t first_free_id() const { return first_free_id_; }

 private:
  struct Left {
    std::shared_ptr<const TerrainRegion> region;
    RegionShapePtr shape;
  };
  /// The part of the loaded region that the other one shows too, in the loaded one's plane; empty: none.
  static FlatPolygon Shared(const Left& left, const TerrainRegion& other);
  void Replace(std::int64_t id, const FlatPolygon& rest);

  std::map<std::int64_t, Left> left_;
  std::int64_t next_piece_id_ = 0;
  std::int64_t first_free_id_ = 0;
};

}  // namespace terrace
