// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_query.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "client/box_section.h"
#include "client/capsule_clearance.h"
#include "client/height_raster.h"
#include "client/spatial_order.h"
#include "core/check.h"

namespace terrace {
TerrainQuery::TerrainQuery(TerrainMapPtr map, const TerrainQuery* before) : map_(std::move(map)) {
  TERRACE_CHECK(map_ != nullptr);
  const bool same_map = before && before->map_->map_id == map_->map_id;
  const std::size_t num_old = same_map ? before->entries_.size() : 0;
  std::size_t old = 0;
  entries_.reserve(map_->regions.size());
  boxes_.reserve(map_->regions.size());
  for (const auto& region : map_->regions) {
    // Most regions are the very ones of the map before; to tell that, nothing of them need be fetched from
    // memory.
    bool known = old < num_old && before->entries_[old].region == region.get();
    if (!known) {
      while (old < num_old && before->entries_[old].region->id < region->id) ++old;
      known = old < num_old && before->entries_[old].region->id == region->id &&
              before->entries_[old].region->revision == region->revision;
    }
    entries_.push_back(
        {region.get(), known ? before->entries_[old].shape : std::make_shared<const RegionShape>(*region)});
    boxes_.push_back(known ? before->boxes_[old] : entries_.back().shape->box_world());
    if (known) ++old;
  }
  order_ = SpatialOrder(boxes_);
  std::vector<Eigen::AlignedBox3d> ordered;
  ordered.reserve(boxes_.size());
  for (const std::uint32_t i : order_) ordered.push_back(boxes_[i]);
  tree_ = BoxTree<3>(std::move(ordered));
}

const TerrainQuery::Entry* TerrainQuery::Find(std::int64_t region_id) const {
  const auto found = std::lower_bound(entries_.begin(), entries_.end(), region_id,
                                      [](const Entry& e, std::int64_t id) { return e.region->id < id; });
  return found != entries_.end() && found->region->id == region_id ? &*found : nullptr;
}

double TerrainQuery::AgeSeconds(const TerrainRegion& region) const {
  return Seconds(map_->t_capture - region.last_seen);
}

bool TerrainQuery::Fits(const Entry& entry, const FootSpec& foot) const {
  const TerrainRegion& region = *entry.region;
  return entry.shape->carries() && foot.labels.Has(region.label) &&
         region.confidence >= foot.min_confidence && (foot.allow_predicted || !region.predicted()) &&
         AgeSeconds(region) <= foot.max_age_s &&
         entry.shape->normal_world().dot(map_->gravity.up_world()) >= std::cos(foot.max_slope_rad);
}

Support TerrainQuery::SupportOn(const Entry& entry, const Eigen::Vector2d& flat) const {
  const FlatPolygon::Approach nearest = entry.shape->polygon().NearestEdge(flat);
  Support support;
  support.point_world = entry.shape->ToWorld(flat);
  support.normal_world = entry.shape->normal_world();
  support.sigma_height_m = entry.shape->SigmaHeight(flat);
  support.edge_distance_m = nearest.distance_m;
  support.edge = entry.shape->edge(nearest.edge);
  support.label = entry.region->label;
  support.confidence = entry.region->confidence;
  support.age_s = AgeSeconds(*entry.region);
  support.source = entry.region->source;
  support.region_id = entry.region->id;
  return support;
}

/// Calls visit(entry, point in its plane) for every ground over and under (x, y).
template <typename Visit>
void TerrainQuery::ForEachAt(const Eigen::Vector2d& xy, const Visit& visit) const {
  tree_.ForEach(
      [&](const Eigen::AlignedBox3d& box) {
        return box.min().x() <= xy.x() && xy.x() <= box.max().x() && box.min().y() <= xy.y() &&
               xy.y() <= box.max().y();
      },
      [&](std::size_t i) {
        const Entry& entry = entries_[order_[i]];
        if (!entry.shape->carries()) return;
        const Eigen::Vector3d point_world(xy.x(), xy.y(), entry.shape->HeightAt(xy));
        visit(entry, point_world);
      });
}

std::optional<Support> TerrainQuery::SupportAt(const Eigen::Vector2d& xy, double z_min, double z_max,
                                               LabelSet labels) const {
  const Entry* highest = nullptr;
  Eigen::Vector3d highest_world = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  ForEachAt(xy, [&](const Entry& entry, const Eigen::Vector3d& point_world) {
    const double z = point_world.z();
    if (!(z >= z_min && z <= z_max) || !labels.Has(entry.region->label)) return;
    // Of equally high ones the lower id, whatever the order in the tree.
    const bool higher = !highest || z > highest_world.z() ||
                        (z == highest_world.z() && entry.region->id < highest->region->id);
    if (!higher || !entry.shape->polygon().Contains(entry.shape->ToPlane(point_world))) return;
    highest = &entry;
    highest_world = point_world;
  });
  if (!highest) return std::nullopt;
  return SupportOn(*highest, highest->shape->ToPlane(highest_world));
}

std::vector<Support> TerrainQuery::SupportsAt(const Eigen::Vector2d& xy) const {
  std::vector<Support> supports;
  ForEachAt(xy, [&](const Entry& entry, const Eigen::Vector3d& point_world) {
    const Eigen::Vector2d flat = entry.shape->ToPlane(point_world);
    if (entry.shape->polygon().Contains(flat)) supports.push_back(SupportOn(entry, flat));
  });
  std::sort(supports.begin(), supports.end(), [](const Support& a, const Support& b) {
    return std::pair(-a.point_world.z(), a.region_id) < std::pair(-b.point_world.z(), b.region_id);
  });
  return supports;
}

std::optional<Foothold> TerrainQuery::NearestFoothold(const Eigen::Vector3d& nominal_world, double reach_xy,
                                                      double dz, const FootSpec& foot) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const EdgeMargins margins{foot.radius_m, foot.radius_m + foot.clear_drop_m,
                            foot.radius_m + foot.clear_rise_m};
  const Eigen::Vector3d reach(reach_xy, reach_xy, dz);
  const Eigen::AlignedBox3d within(nominal_world - reach, nominal_world + reach);
  Eigen::Vector2d best_flat = Eigen::Vector2d::Zero();
  double best_squared = kNone;
  const auto nearest = tree_.FindNearest(
      [&](const Eigen::AlignedBox3d& box) {
        return box.intersects(within) ? box.squaredExteriorDistance(nominal_world) : kNone;
      },
      [&](std::size_t i) {
        const Entry& entry = entries_[order_[i]];
        const Eigen::AlignedBox3d& box = entry.shape->box_world();
        if (!box.intersects(within) || box.squaredExteriorDistance(nominal_world) >= best_squared ||
            !Fits(entry, foot))
          return kNone;
        const auto inset = entry.shape->Inset(margins);
        if (inset->empty()) return kNone;
        Eigen::Vector2d flat = entry.shape->ToPlane(nominal_world);
        if (!inset->Contains(flat)) flat = inset->NearestEdge(flat).point;
        const Eigen::Vector3d away = entry.shape->ToWorld(flat) - nominal_world;
        if (away.head<2>().norm() > reach_xy || std::abs(away.z()) > dz) return kNone;
        if (away.squaredNorm() < best_squared) {
          best_squared = away.squaredNorm();
          best_flat = flat;
        }
        return away.squaredNorm();
      });
  if (best_squared == kNone) return std::nullopt;
  return Foothold{SupportOn(entries_[order_[nearest.index]], best_flat), std::sqrt(best_squared)};
}

std::vector<std::int64_t> TerrainQuery::RegionsIn(const Eigen::AlignedBox3d& box_world,
                                                  LabelSet labels) const {
  std::vector<std::int64_t> ids;
  tree_.ForEach([&](const Eigen::AlignedBox3d& box) { return box.intersects(box_world); },
                [&](std::size_t i) {
                  const Entry& entry = entries_[order_[i]];
                  if (labels.Has(entry.region->label) && ReachesInto(*entry.shape, box_world))
                    ids.push_back(entry.region->id);
                });
  std::sort(ids.begin(), ids.end());
  return ids;
}

Clearance TerrainQuery::CapsuleClearance(const Eigen::Vector3d& a_world, const Eigen::Vector3d& b_world,
                                         double radius_m, LabelSet labels, const OccupiedSpace* space) const {
  return ClearanceOf(*this, {a_world, b_world, radius_m}, labels, space);
}

HeightGrid TerrainQuery::Heights(const HeightGridSpec& spec) const { return RasterHeights(*this, spec); }

}  // namespace terrace
