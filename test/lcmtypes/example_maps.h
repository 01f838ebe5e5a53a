// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>

#include "core/terrain_map.h"

namespace terrace {

/// Made-up maps with every member set, for tests of what carries maps.
class ExampleMaps {
 public:
  explicit ExampleMaps(unsigned seed) : random_(seed) {}

  std::shared_ptr<TerrainRegion> Region(std::int64_t id, int revision) {
    auto region = std::make_shared<TerrainRegion>();
    region->id = id;
    region->revision = revision;
    region->label = static_cast<TerrainLabel>(Int(0, kNumTerrainLabels - 1));
    region->confidence = Real(0.0, 1.0);
    region->plane_world.normal = Eigen::Vector3d(Real(-1, 1), Real(-1, 1), Real(0.1, 1)).normalized();
    region->plane_world.offset_m = Real(-2.0, 2.0);
    const PlaneAxes axes = AxesOf(region->plane_world.normal);
    region->centroid_world = region->plane_world.offset_m * region->plane_world.normal +
                             Real(-5, 5) * axes.x + Real(-5, 5) * axes.y;
    region->plane_covariance = Eigen::Vector3d(1e-4, 2e-4, 1e-6).asDiagonal();
    region->plane_covariance(0, 2) = region->plane_covariance(2, 0) = 3e-6;
    region->rms_m = Real(0.0, 0.02);
    region->area_m2 = Real(0.1, 5.0);
    region->outline_world = RingInPlane(region->plane_world, Int(3, 20), 1.0, false);
    for (int i = Int(0, 2); i > 0; --i) {
      region->holes_world.push_back(RingInPlane(region->plane_world, Int(3, 6), 0.1 * i, true));
    }
    std::size_t num_vertices = region->outline_world.size();
    for (const Ring& hole : region->holes_world) num_vertices += hole.size();
    for (std::size_t i = 0; i < num_vertices; ++i) region->edges.push_back(Edge());
    region->support = Real(0.0, 1.0);
    region->source = static_cast<RegionSource>(Int(0, kNumRegionSources - 1));
    if (region->label == TerrainLabel::kUnknown) region->why = "too few points";
    if (Int(0, 1) == 1) {
      region->staircase_id = newest_staircase_id_;
      region->step_index = Int(1, 9);
    }
    region->num_observations = Int(1, 1000);
    region->first_seen = {1600000000000001000};
    region->last_seen = {1600000002000005000};
    return region;
  }

  Staircase Stairs(std::int64_t id) {
    Staircase stairs;
    stairs.id = id;
    stairs.num_risers = Int(2, 20);
    stairs.num_treads = stairs.num_risers - 1;
    stairs.riser_m = Real(0.1, 0.2);
    stairs.riser_sigma_m = 0.002;
    stairs.tread_m = Real(0.2, 0.4);
    stairs.tread_sigma_m = 0.004;
    stairs.width_m = Real(0.5, 3.0);
    stairs.foot_edge_world = {Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(4, 5, 6)};
    stairs.head_edge_world = {Eigen::Vector3d(7, 8, 9), Eigen::Vector3d(10, 11, 12)};
    stairs.direction_up_world = {0.6, 0.8, 0.0};
    stairs.turn_per_step_rad = 0.1;
    stairs.pitch_rad = 0.5;
    stairs.confidence = Real(0.0, 1.0);
    stairs.last_seen = {1600000002000006000};
    return stairs;
  }

  /// The first map of a run.
  TerrainMap First(int num_regions) {
    TerrainMap map;
    map.t_capture = {1600000000000000000};
    map.seq = 1;
    map.T_world_left.translation() = Eigen::Vector3d(1, 2, 3);
    map.covariance = Matrix6d::Identity() * 0.25;
    map.gravity = {Eigen::Vector3d(0.01, 0.0, -1.0).normalized(), 0.125, GravitySource::kPlane};
    next_id_ = 1;
    newest_staircase_id_ = 1;
    map.staircases.push_back(Stairs(1));
    for (int i = 0; i < num_regions; ++i) map.regions.push_back(Region(next_id_++, 1));
    ListTheRegionsOfStaircases(&map);
    return map;
  }

  /// Some regions change, some go, some come, all others are shared with the map before.
  TerrainMap Next(const TerrainMap& before) {
    TerrainMap map = before;
    ++map.seq;
    map.t_capture.ns += 66667000;
    map.regions.clear();
    if (Int(0, 7) == 0 && map.staircases.size() > 1) map.staircases.erase(map.staircases.begin());
    if (Int(0, 3) == 0) map.staircases.push_back(Stairs(++newest_staircase_id_));
    for (const auto& region : before.regions) {
      const int fate = Int(0, 9);
      if (fate == 0) continue;
      map.regions.push_back(fate <= 2 ? Region(region->id, region->revision + 1) : region);
    }
    for (int i = Int(0, 3); i > 0; --i) map.regions.push_back(Region(next_id_++, 1));
    ListTheRegionsOfStaircases(&map);
    return map;
  }

 private:
  /// Regions of a staircase that is gone change, and staircases list what belongs to them.
  void ListTheRegionsOfStaircases(TerrainMap* map) {
    for (Staircase& stairs : map->staircases) stairs.region_ids.clear();
    for (auto& region : map->regions) {
      if (!region->staircase_id) continue;
      const auto stairs = std::find_if(map->staircases.begin(), map->staircases.end(),
                                       [&](const Staircase& s) { return s.id == region->staircase_id; });
      if (stairs != map->staircases.end()) {
        stairs->region_ids.push_back(region->id);
        continue;
      }
      auto changed = std::make_shared<TerrainRegion>(*region);
      ++changed->revision;
      changed->staircase_id.reset();
      changed->step_index.reset();
      region = changed;
    }
  }

  RegionEdge Edge() {
    RegionEdge edge;
    edge.kind = static_cast<EdgeKind>(Int(0, kNumEdgeKinds - 1));
    // Numbers that a float holds.
    if (Int(0, 2) > 0) edge.step_m = 0.125 * Int(-8, 8);
    if (edge.step_m && Int(0, 1) == 1) edge.sigma_m = 0.0078125 * Int(1, 8);
    return edge;
  }

  int Int(int min, int max) { return std::uniform_int_distribution<int>(min, max)(random_); }
  double Real(double min, double max) { return std::uniform_real_distribution<double>(min, max)(random_); }

  Ring RingInPlane(const Plane& plane, int size, double radius_m, bool clockwise) {
    const PlaneAxes axes = AxesOf(plane.normal);
    Ring ring;
    for (int i = 0; i < size; ++i) {
      const double angle = (clockwise ? -1 : 1) * 2.0 * M_PI * i / size;
      ring.push_back(plane.offset_m * plane.normal + radius_m * (1.0 + std::cos(angle)) * axes.x +
                     radius_m * std::sin(angle) * axes.y);
    }
    return ring;
  }

  std::mt19937 random_;
  std::int64_t next_id_ = 1;
  std::int64_t newest_staircase_id_ = 1;
};

}  // namespace terrace
