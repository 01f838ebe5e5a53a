// SPDX-License-Identifier: BSD-3-Clause
#include "bench/client/true_ground.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace terrace {
namespace {

constexpr double kHeightTolerance_m = 0.01;
constexpr double kSoleTolerance_m = 0.01;

bool TrulyAt(const TerrainQuery& truth, const Eigen::Vector3d& p) {
  return truth.SupportAt(p.head<2>(), p.z() - kHeightTolerance_m, p.z() + kHeightTolerance_m).has_value();
}

}  // namespace

TerrainMapPtr TrueGround(const TrueScene& scene, const Eigen::Isometry3d& T_map_truth) {
  auto map = std::make_shared<TerrainMap>();
  for (const TruePolygon& polygon : scene.polygons) {
    const auto label = TerrainLabelFromName(polygon.label);
    if (!label || !kWalkableLabels.Has(*label)) continue;
    auto region = std::make_shared<TerrainRegion>();
    region->id = polygon.id;
    region->label = *label;
    region->confidence = 1.0;
    region->plane_world.normal = T_map_truth.linear() * polygon.plane_world.normal;
    const auto moved = [&](const Ring& ring) {
      Ring result;
      for (const Eigen::Vector3d& p : ring) result.push_back(T_map_truth * p);
      return result;
    };
    region->outline_world = moved(polygon.outline_world);
    for (const Ring& hole : polygon.holes_world) region->holes_world.push_back(moved(hole));
    region->centroid_world = region->outline_world.front();
    region->plane_world.offset_m = region->plane_world.normal.dot(region->centroid_world);
    map->regions.push_back(region);
  }
  std::sort(map->regions.begin(), map->regions.end(),
            [](const auto& a, const auto& b) { return a->id < b->id; });
  return map;
}

bool IsRightFoothold(const TerrainQuery& truth, const Support& ground, double foot_radius_m) {
  if (!TrulyAt(truth, ground.point_world)) return false;
  constexpr int kPoints = 16;
  const PlaneAxes axes = AxesOf(ground.normal_world);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * M_PI * i / kPoints;
    const Eigen::Vector3d around = std::cos(angle) * axes.x + std::sin(angle) * axes.y;
    if (!TrulyAt(truth, ground.point_world + (foot_radius_m - kSoleTolerance_m) * around)) return false;
  }
  return true;
}

}  // namespace terrace
