// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "polygonization/cell_modeller.h"
#include "polygonization/merging_config.h"
#include "polygonization/surface_store.h"

namespace terrace {

/// Decides what belongs together: which surface a new patch joins, which surfaces are one, and who has to
/// leave.
class SurfaceGrower {
 public:
  SurfaceGrower(const MergingConfig& config, SurfaceStore* store) : config_(config), store_(*store) {}

  /// Puts the new patches in the place of the old ones and finds a surface for each.
  void Grow(const PatchUpdate& update);

 private:
  void Replace(const PatchUpdate& update);
  /// Whether new patches of a cell show as much as is known of it from before its points were forgotten.
  bool KnowsAsMuch(const PatchUpdate::CellPatches& cell) const;
  void EvictLeaning(const PatchUpdate& update);
  /// Whether a patch, and those of its surface around it, lean against the plane of the surface the same way.
  bool LeansWithOthers(const CellKey& key, const Member& member) const;
  void FindHomes();
  void JoinSurfaces(const PatchUpdate& update);
  void EvictMisfits();
  /// How badly a patch fits a surface, or nothing when it does not belong there at all.
  std::optional<double> Misfit(const Member& member, const Surface& surface, double slack) const;
  bool OnePlane(const Surface& a, const Surface& b) const;
  bool TooLarge(const Eigen::AlignedBox3d& box_world) const;
  bool Near(const Member& a, const Member& b) const;
  template <typename Visitor>
  void ForEachNeighbour(const MemberRef& ref, const Visitor& visit) const;
  SurfaceId Survivor(SurfaceId id) const;

  const MergingConfig& config_;
  SurfaceStore& store_;
  // Of the update at hand.
  std::vector<MemberRef> homeless_;
  std::map<MemberRef, SurfaceId> left_;  // where a patch does not come back to
  std::map<SurfaceId, SurfaceId> absorbed_by_;
};

}  // namespace terrace
