// SPDX-License-Identifier: BSD-3-Clause
#include "client/example/footsteps/plan_picture.h"

#include <algorithm>
#include <cstdio>

#include <Eigen/Geometry>

namespace terrace {
namespace {

constexpr double kPixelsPerMetre = 120.0;
constexpr double kMargin_m = 0.3;
constexpr double kGround = 0.5;  // what faces up more than 60 deg

const char* ColourOf(TerrainLabel label) {
  switch (label) {
    case TerrainLabel::kWalkway:
      return "#a8d8a0";
    case TerrainLabel::kRamp:
      return "#d8cf8c";
    case TerrainLabel::kStairTread:
      return "#8cc4e8";
    case TerrainLabel::kObstacle:
      return "#d09080";
    default:
      return "#d0d0d0";
  }
}

template <typename... Values>
void Append(std::string* text, const char* format, Values... values) {
  char line[256];
  std::snprintf(line, sizeof(line), format, values...);
  *text += line;
}

}  // namespace

std::string PlanPicture(const TerrainMap& map, const std::vector<Footstep>& steps, double foot_radius_m) {
  std::vector<const TerrainRegion*> ground;
  Eigen::AlignedBox2d box;
  for (const auto& region : map.regions) {
    if (region->plane_world.normal.z() < kGround) continue;
    ground.push_back(region.get());
    for (const Eigen::Vector3d& p : region->outline_world) box.extend(p.head<2>());
  }
  if (ground.empty()) box = Eigen::AlignedBox2d(Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones());
  // What lies higher is drawn later.
  std::sort(ground.begin(), ground.end(), [](const TerrainRegion* a, const TerrainRegion* b) {
    return a->centroid_world.z() < b->centroid_world.z();
  });
  const auto x = [&](const Eigen::Vector3d& p) {
    return (p.x() - box.min().x() + kMargin_m) * kPixelsPerMetre;
  };
  const auto y = [&](const Eigen::Vector3d& p) {
    return (box.max().y() - p.y() + kMargin_m) * kPixelsPerMetre;
  };
  const Eigen::Vector2d size = (box.sizes() + Eigen::Vector2d::Constant(2.0 * kMargin_m)) * kPixelsPerMetre;
  std::string svg;
  Append(&svg, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\">\n", size.x(),
         size.y());
  svg += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (const TerrainRegion* region : ground) {
    std::vector<Ring> rings{region->outline_world};
    rings.insert(rings.end(), region->holes_world.begin(), region->holes_world.end());
    Append(&svg, "<path fill-rule=\"evenodd\" stroke=\"#606060\" fill=\"%s\"%s d=\"", ColourOf(region->label),
           region->predicted() ? " stroke-dasharray=\"4\"" : "");
    for (const Ring& ring : rings) {
      for (std::size_t i = 0; i < ring.size(); ++i)
        Append(&svg, "%c%.1f %.1f", i == 0 ? 'M' : 'L', x(ring[i]), y(ring[i]));
      svg += "Z";
    }
    svg += "\"/>\n";
  }
  for (const Footstep& step : steps) {
    const Eigen::Vector3d& p = step.ground.point_world;
    Append(&svg, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\"/>\n", x(p), y(p),
           foot_radius_m * kPixelsPerMetre, step.left ? "#c02020" : "#2040c0");
  }
  return svg + "</svg>\n";
}

}  // namespace terrace
