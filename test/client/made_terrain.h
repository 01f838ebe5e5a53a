// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/terrain_map.h"

namespace terrace {

/// A ring in the plan, to be lifted into a plane.
using PlanRing = std::vector<Eigen::Vector2d>;

inline PlanRing Rectangle(double min_x, double min_y, double max_x, double max_y) {
  return {{min_x, min_y}, {max_x, min_y}, {max_x, max_y}, {min_x, max_y}};
}

/// A region over outline and holes in the plan; all edges of one kind; seen at 10 s.
inline std::shared_ptr<TerrainRegion> MadeRegion(std::int64_t id, TerrainLabel label, const Plane& plane,
                                                 const PlanRing& outline,
                                                 const std::vector<PlanRing>& holes = {},
                                                 EdgeKind kind = EdgeKind::kLimitOfView) {
  const auto lift = [&](const PlanRing& ring, bool clockwise) {
    Ring lifted;
    for (const Eigen::Vector2d& p : ring) {
      const double z = (plane.offset_m - plane.normal.head<2>().dot(p)) / plane.normal.z();
      lifted.emplace_back(p.x(), p.y(), z);
    }
    if (clockwise) lifted = Ring(lifted.rbegin(), lifted.rend());
    return lifted;
  };
  auto region = std::make_shared<TerrainRegion>();
  region->id = id;
  region->revision = 1;
  region->label = label;
  region->confidence = 0.9;
  region->plane_world = plane;
  region->outline_world = lift(outline, false);
  for (const PlanRing& hole : holes) region->holes_world.push_back(lift(hole, true));
  region->area_m2 = SignedArea(region->outline_world, plane.normal);
  std::size_t num_vertices = region->outline_world.size();
  region->centroid_world.setZero();
  for (const Eigen::Vector3d& p : region->outline_world) region->centroid_world += p;
  region->centroid_world = plane.Project(region->centroid_world / static_cast<double>(num_vertices));
  for (const Ring& hole : region->holes_world) {
    region->area_m2 += SignedArea(hole, plane.normal);
    num_vertices += hole.size();
  }
  region->edges.assign(num_vertices, RegionEdge{kind, std::nullopt, std::nullopt});
  region->plane_covariance = Eigen::Vector3d(1e-4, 4e-4, 1e-6).asDiagonal();
  region->first_seen = {1'000'000'000};
  region->last_seen = {10'000'000'000};
  return region;
}

inline Plane LevelAt(double z) { return {Eigen::Vector3d::UnitZ(), z}; }

inline std::shared_ptr<TerrainMap> MadeMap(std::vector<std::shared_ptr<const TerrainRegion>> regions) {
  auto map = std::make_shared<TerrainMap>();
  map->t_capture = {12'000'000'000};
  map->seq = 1;
  map->regions = std::move(regions);
  return map;
}

/// Ragged regions of all labels, level, sloping and upright, with holes, scattered and stacked.
class ScatteredTerrain {
 public:
  explicit ScatteredTerrain(unsigned seed) : random_(seed) {}

  double Real(double min, double max) { return std::uniform_real_distribution<double>(min, max)(random_); }
  int Int(int min, int max) { return std::uniform_int_distribution<int>(min, max)(random_); }

  PlanRing Ragged(const Eigen::Vector2d& middle, double radius_m, int num_vertices) {
    PlanRing ring;
    for (int i = 0; i < num_vertices; ++i) {
      const double angle = 2.0 * M_PI * i / num_vertices;
      ring.push_back(middle + radius_m * Real(0.6, 1.0) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    return ring;
  }

  std::shared_ptr<TerrainRegion> Region(std::int64_t id, double half_extent_m, int num_vertices = 24) {
    const Eigen::Vector2d middle(Real(-half_extent_m, half_extent_m), Real(-half_extent_m, half_extent_m));
    const double tilt = Int(0, 2) == 0 ? Real(0.0, 1.2) : Real(0.0, 0.05);
    const double heading = Real(-M_PI, M_PI);
    Plane plane;
    plane.normal = Eigen::Vector3d(std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading),
                                   std::cos(tilt));
    plane.offset_m = plane.normal.dot(Eigen::Vector3d(middle.x(), middle.y(), 0.5 * Int(0, 3)));
    const double radius_m = Real(0.2, 0.8);
    std::vector<PlanRing> holes;
    if (Int(0, 1) == 1) holes.push_back(Ragged(middle, 0.3 * radius_m, 7));
    auto region = MadeRegion(id, static_cast<TerrainLabel>(Int(0, kNumTerrainLabels - 1)), plane,
                             Ragged(middle, radius_m, num_vertices), holes);
    for (RegionEdge& edge : region->edges) edge.kind = static_cast<EdgeKind>(Int(0, kNumEdgeKinds - 1));
    region->confidence = Real(0.3, 1.0);
    region->source = Int(0, 5) == 0 ? RegionSource::kPredicted : RegionSource::kSeen;
    region->last_seen = {static_cast<std::int64_t>(Real(1e9, 12e9))};
    return region;
  }

  std::shared_ptr<TerrainMap> Map(int num_regions, double half_extent_m, int num_vertices = 24) {
    std::vector<std::shared_ptr<const TerrainRegion>> regions;
    for (int i = 1; i <= num_regions; ++i) regions.push_back(Region(i, half_extent_m, num_vertices));
    return MadeMap(std::move(regions));
  }

 private:
  std::mt19937 random_;
};

}  // namespace terrace
