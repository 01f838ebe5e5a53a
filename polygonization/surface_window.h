// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/Core>

#include "polygonization/far_surface.h"
#include "polygonization/map_reach.h"
#include "polygonization/polygon_map.h"
#include "polygonization/surface_store.h"

namespace terrace {

/// Keeps in the store the surfaces that lie within the window, with those that meet them, since those are
/// asked when an outline is traced. Of the others it keeps what is needed to put them back when the camera
/// returns. Places are told apart by blocks of cells; nothing happens until the camera comes into another
/// one.
///
/// What always holds: a surface is in the store or among the far ones, never in both, and a far one has
/// polygons.
class SurfaceWindow {
 public:
  explicit SurfaceWindow(const MapReach& reach) : reach_(reach) {}

  /// Takes surfaces out of the store and puts others back, as the camera has moved.
  /// @param waiting  surfaces that stay, since they are not yet what their evidence says
  /// @return polygons that lie so far away that they are forgotten, ascending
  std::vector<PolygonId> Move(const Eigen::Vector3d& p_world, const std::set<SurfaceId>& waiting,
                              const PolygonMap& polygons, SurfaceStore* store);

  const std::map<SurfaceId, FarSurface>& far() const { return far_; }
  /// Heap; counted as surfaces come and go.
  std::int64_t memory_bytes() const { return bytes_; }

 private:
  using Blocks = std::set<CellKey>;  // by their own keys

  CellKey BlockAt(const Eigen::Vector3d& p_world) const;
  /// Least distance between a point of the camera's block and one of another.
  double Distance(const CellKey& block) const;
  bool Within(const Blocks& blocks, double distance_m) const;
  void AddAround(const Blocks& blocks, double distance_m, Blocks* around) const;
  std::set<SurfaceId> FarOnesIn(const Blocks& blocks) const;
  std::set<SurfaceId> FarOnesWithin(double distance_m) const;

  void BringBackNear(const PolygonMap& polygons, SurfaceStore* store);
  void TakeAwayFar(const std::set<SurfaceId>& waiting, SurfaceStore* store);
  std::vector<PolygonId> ForgetBeyond();
  void Put(SurfaceId id, const Blocks& blocks, FarSurface far);
  FarSurface Take(SurfaceId id);

  const MapReach reach_;
  std::optional<CellKey> block_;  // of the camera
  std::map<SurfaceId, FarSurface> far_;
  std::map<CellKey, std::set<SurfaceId>> far_by_block_;
  std::int64_t bytes_ = 0;
};

}  // namespace terrace
