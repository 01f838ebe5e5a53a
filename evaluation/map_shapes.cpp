// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/map_shapes.h"

#include <stdexcept>

namespace terrace {
namespace {

/// 160,000 m^2: no map of a walking robot.
constexpr double kMaxRegion_m2 = 1.6e5;

}  // namespace

std::vector<MapRegion> MoveRegions(const TerrainMap& map, const Eigen::Isometry3d& T_true_result) {
  std::vector<MapRegion> regions;
  for (const auto& region : map.regions) {
    if (region->predicted()) continue;
    std::vector<Ring> holes;
    for (const Ring& hole : region->holes_world) holes.push_back(Moved(T_true_result, hole));
    regions.push_back({region.get(),
                       PlanarShape(Moved(T_true_result, region->plane_world),
                                   Moved(T_true_result, region->outline_world), holes),
                       Name(region->label)});
    if (regions.back().shape.BoxArea() > kMaxRegion_m2) {
      throw std::runtime_error("region " + std::to_string(region->id) + " is too large to be true");
    }
  }
  return regions;
}

std::vector<TrueShape> ShapesOf(const TrueScene& truth, const MapEvaluationOptions& options) {
  std::vector<TrueShape> shapes;
  for (const TruePolygon& polygon : truth.polygons) {
    const bool asked =
        (options.include_other || polygon.label != "other") && (options.include_detail || !polygon.detail);
    shapes.push_back(
        {&polygon, PlanarShape(polygon.plane_world, polygon.outline_world, polygon.holes_world), asked});
  }
  return shapes;
}

bool IsWalkable(const std::string& label) {
  return label == Name(TerrainLabel::kWalkway) || label == Name(TerrainLabel::kRamp) ||
         label == Name(TerrainLabel::kStairTread);
}

}  // namespace terrace
