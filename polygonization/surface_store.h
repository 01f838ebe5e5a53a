// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <set>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/time.h"
#include "mapping/terrain_octree.h"
#include "polygonization/cell_modeller.h"
#include "polygonization/evidence_grid.h"
#include "polygonization/outline_tracer.h"
#include "polygonization/plane_frame.h"
#include "polygonization/plane_moments.h"
#include "polygonization/polygon.h"

namespace terrace {

using SurfaceId = std::int64_t;
constexpr SurfaceId kNoSurface = 0;

/// What stays wrong with a patch however many points it has (pixel locking, calibration).
constexpr double kSystematic_m = 0.003;

/// What one leaf covers, in the axes of its patch's plane [m], in a quarter of the memory of a Footprint.
/// Half the digits of a float are finer than a tenth of a millimetre here.
struct SmallFootprint {
  std::array<Eigen::half, 2> centre;
  std::array<Eigen::half, 2> half_long;  ///< from the centre to the middle of one edge
  Eigen::half half_short;                ///< length of the other half edge, across the first
};

/// A patch of the map, and what it is part of.
struct Member {
  Patch patch;  ///< its footprints are kept below
  std::vector<SmallFootprint> footprints;
  Eigen::Vector3d mean_world;
  Eigen::Vector3d low_world, high_world;  ///< box around its leaves
  double angle_sigma_rad = 0.0;           ///< how well its own normal is known
  SurfaceId surface = kNoSurface;
  PolygonId polygon = 0;  ///< the polygon that it was part of last
};

struct CellMembers {
  Eigen::Vector3d centre_world;
  std::vector<Member> members;
  /// The points that the members were fitted to are forgotten: the members stay until as much is known again.
  bool folded = false;
};

/// Names a member until its cell gets new patches.
struct MemberRef {
  CellKey cell;
  int index = 0;
  friend auto operator<=>(const MemberRef&, const MemberRef&) = default;
};

/// Patches that lie in one plane and hang together; published as one polygon for each connected piece.
struct Surface {
  Plane plane_world;
  PlaneMoments moments;  ///< relative to `origin_world`
  Eigen::Vector3d origin_world;
  double angle_sigma_rad = 0.0;
  double noise_m = 0.0;  ///< of single points, as that of patches
  double area_m2 = 0.0;  ///< of its patches
  /// Evidence and outlines are kept in these axes, which stay when the plane moves a little.
  Eigen::Vector3d anchor_normal;
  PlaneAxes axes;
  EvidenceGrid evidence;
  int num_flipped = 0;  ///< cells of the evidence that came or went since it was traced
  std::set<CellKey> cells;
  Eigen::AlignedBox3d box_world;  ///< around all members that it ever had
  std::vector<PolygonId> polygons;
  std::vector<TracedPiece> pieces;  ///< of the polygons, as last traced
  FrameId traced_frame = 0;
  bool trace_now = true;  ///< the pieces are missing, or of two surfaces

  PlaneFrame Frame() const { return {plane_world, origin_world, axes, anchor_normal}; }
};

/// Surfaces beside another one, and the box around their patches there.
using Neighbours = std::map<SurfaceId, Eigen::AlignedBox3d>;

/// The surfaces and the patches that they are made of. What holds between two frames:
///  - every patch is a member of the cell that it was fitted in, and of one surface;
///  - a surface's `cells` are those that hold a member of it, and there is at least one;
///  - its moments are the sums of those of its members, and its plane follows from them;
///  - its polygons and its traced pieces go in pairs. (Only where it took one in that had polygons are there
///    more of them, until it is traced anew: `trace_now`.)
///  - its evidence has room wherever its members lie.
/// While a frame is worked in, `touched` names the surfaces whose members have changed.
class SurfaceStore {
 public:
  /// @param cell_m  of the evidence
  explicit SurfaceStore(double cell_m = 0.01) : cell_m_(cell_m) {}

  Member& At(const MemberRef& ref) {
    return cells_.at(ref.cell).members[static_cast<std::size_t>(ref.index)];
  }
  const Member& At(const MemberRef& ref) const {
    return cells_.at(ref.cell).members[static_cast<std::size_t>(ref.index)];
  }
  /// Null where the cell has no members.
  const CellMembers* Find(const CellKey& key) const;
  /// Calls visit(key, cell) for the cell and those of the 26 around it that have members.
  template <typename Visitor>
  void ForEachAround(const CellKey& key, const Visitor& visit) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const CellKey around{key.x + dx, key.y + dy, key.z + dz};
          if (const CellMembers* cell = Find(around)) visit(around, *cell);
        }
      }
    }
  }
  /// True when the predicate holds for a member of the cell or of the 26 around it.
  template <typename Predicate>
  bool AnyAround(const CellKey& key, const Predicate& predicate) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const CellMembers* cell = Find({key.x + dx, key.y + dy, key.z + dz});
          if (cell && std::any_of(cell->members.begin(), cell->members.end(), predicate)) return true;
        }
      }
    }
    return false;
  }

  std::map<SurfaceId, Surface>& surfaces() { return surfaces_; }
  const std::map<SurfaceId, Surface>& surfaces() const { return surfaces_; }
  std::set<SurfaceId>& touched() { return touched_; }

  /// The points of a cell are forgotten: its members stay, compact, and take no evidence any more.
  void Fold(const CellKey& key);
  /// The members of a cell leave their surfaces and the store.
  std::vector<Member> TakeOut(const CellKey& key);
  /// A patch comes into its cell, without a surface yet.
  MemberRef Add(const CellKey& key, const Eigen::Vector3d& centre_world, const Patch& patch);
  /// A patch whose points are forgotten comes into its cell, without a surface yet.
  MemberRef AddFolded(const CellKey& key, const Eigen::Vector3d& centre_world, const Patch& patch);
  void Join(const MemberRef& ref, SurfaceId id);
  /// A member is without a surface from now on.
  void Leave(const MemberRef& ref);
  /// A surface of its own for a member.
  void Found(const MemberRef& ref);
  /// A surface without members, under an id that is not in the store.
  Surface& Begin(SurfaceId id);
  /// A surface leaves the store with its members.
  void Remove(SurfaceId id);
  /// Members and polygons of one surface go over to another.
  void Absorb(SurfaceId keep, SurfaceId lose);
  /// The members of a surface that do not `stay(member)` are without one from now on; they are returned.
  template <typename Predicate>
  std::vector<MemberRef> Evict(SurfaceId id, const Predicate& stay) {
    std::vector<MemberRef> evicted;
    Surface& surface = surfaces_.at(id);
    for (const CellKey& key : std::vector<CellKey>(surface.cells.begin(), surface.cells.end())) {
      auto& members = cells_.at(key).members;
      bool still_here = false;
      for (int i = 0; i < static_cast<int>(members.size()); ++i) {
        Member& member = members[static_cast<std::size_t>(i)];
        if (member.surface != id) continue;
        if (stay(member)) {
          still_here = true;
        } else {
          member.surface = kNoSurface;
          evicted.push_back({key, i});
        }
      }
      if (!still_here) surface.cells.erase(key);
    }
    return evicted;
  }

  /// The planes of the surfaces touched, from the moments of their members.
  void RefitTouched();

  /// Published surfaces with patches in or beside the cells of this one.
  Neighbours NeighboursOf(SurfaceId id) const;
  /// A surface takes evidence where the leaves of its members lie now, and no longer where others lay.
  void Reopen(SurfaceId id);

  std::int64_t memory_bytes() const;

 private:
  struct CellKeyHash {
    std::size_t operator()(const CellKey& key) const;
  };
  void Refit(SurfaceId id, Surface* surface);

  double cell_m_;
  std::unordered_map<CellKey, CellMembers, CellKeyHash> cells_;
  std::map<SurfaceId, Surface> surfaces_;
  std::set<SurfaceId> touched_;
  SurfaceId next_surface_ = 1;
  std::int64_t footprint_bytes_ = 0;
};

}  // namespace terrace
