// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "client/box_tree.h"
#include "client/query_types.h"
#include "client/region_shape.h"
#include "core/terrain_map.h"

namespace terrace {

class OccupiedSpace;

/// Where a foot may be set.
struct Foothold {
  Support support;
  double distance_m = 0.0;  ///< from the nominal point
};

/// Questions to one map. It never changes, and may be asked from any thread; the next map's query takes over
/// what has not changed. Everything is in the world frame, in metres, radians and seconds.
class TerrainQuery {
 public:
  /// @param map  not null
  /// @param before  the query of an earlier map, whose prepared regions are shared where id and revision
  /// agree
  explicit TerrainQuery(TerrainMapPtr map, const TerrainQuery* before = nullptr);

  const TerrainMap& map() const { return *map_; }

  /// The highest ground over or under (x, y) with a height in [z_min, z_max] and one of the labels; none:
  /// nothing is known there. Only what faces up within 60 deg is ground.
  std::optional<Support> SupportAt(const Eigen::Vector2d& xy, double z_min, double z_max,
                                   LabelSet labels = kWalkableLabels) const;
  /// The ground of all storeys at (x, y), whatever its label, the highest first.
  std::vector<Support> SupportsAt(const Eigen::Vector2d& xy) const;

  /// The place for a foot that is nearest to a nominal one. Of every region that fits the foot, the point
  /// nearest to `nominal_world` is looked at; those that are further than `reach_xy` from it in the plan, or
  /// than `dz` in height, do not count. None: no ground that is known well enough is within reach.
  std::optional<Foothold> NearestFoothold(const Eigen::Vector3d& nominal_world, double reach_xy, double dz,
                                          const FootSpec& foot = {}) const;

  /// Ids of the regions of which any point lies in the box, ascending; upright ones too.
  std::vector<std::int64_t> RegionsIn(const Eigen::AlignedBox3d& box_world,
                                      LabelSet labels = kAllLabels) const;

  /// How far all points within `radius_m` of the segment from a to b (a leg, a body) are from the faces of
  /// regions with one of the labels, and from what else takes up space.
  /// @param space  what the octree says around there (occupied_space.h), of this map; null: nobody has asked
  /// it, and nothing is called free
  Clearance CapsuleClearance(const Eigen::Vector3d& a_world, const Eigen::Vector3d& b_world, double radius_m,
                             LabelSet labels = kAllLabels, const OccupiedSpace* space = nullptr) const;

  /// The highest ground in every cell, as SupportAt has it at the cell's middle.
  HeightGrid Heights(const HeightGridSpec& spec) const;

  /// A region with its prepared geometry; for questions of your own.
  struct Entry {
    const TerrainRegion* region = nullptr;
    RegionShapePtr shape;
  };
  const std::vector<Entry>& entries() const { return entries_; }  ///< ascending by id
  const Entry* Find(std::int64_t region_id) const;                ///< null: there is none
  /// Over entries(), by their boxes: item i of the tree is entry order()[i].
  const BoxTree<3>& tree() const { return tree_; }
  const std::vector<std::uint32_t>& order() const { return order_; }

  /// What is known of an entry's ground at (x, y), whether or not it reaches there.
  Support SupportOn(const Entry& entry, const Eigen::Vector2d& flat) const;
  /// Whether a foot may stand on the region at all, its edges aside.
  bool Fits(const Entry& entry, const FootSpec& foot) const;
  double AgeSeconds(const TerrainRegion& region) const;

 private:
  template <typename Visit>
  void ForEachAt(const Eigen::Vector2d& xy, const Visit& visit) const;

  TerrainMapPtr map_;
  std::vector<Entry> entries_;
  std::vector<Eigen::AlignedBox3d> boxes_;  // of the entries
  std::vector<std::uint32_t> order_;
  BoxTree<3> tree_;
};

}  // namespace terrace
