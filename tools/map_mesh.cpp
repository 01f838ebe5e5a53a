// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/flat_polygon.h"
#include "client/region_shape.h"

namespace terrace {
namespace {

/// An edge that goes from one cut to the next, by its x at both.
struct Side {
  double low_x = 0.0;
  double high_x = 0.0;
};

std::vector<Side> SidesBetween(const FlatPolygon& polygon, double low_y, double high_y) {
  std::vector<Side> sides;
  for (std::size_t i = 0; i < polygon.num_edges(); ++i) {
    Eigen::Vector2d a = polygon.start(i), b = polygon.end(i);
    if (a.y() > b.y()) std::swap(a, b);
    if (a.y() > low_y || b.y() < high_y || a.y() == b.y()) continue;
    const auto x_at = [&](double y) { return a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y())); };
    sides.push_back({x_at(low_y), x_at(high_y)});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::pair(a.low_x + a.high_x, a.low_x) < std::pair(b.low_x + b.high_x, b.low_x);
  });
  return sides;
}

/// From one point to the other, both included.
void AddLine(const RegionShape& shape, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
             double spacing_m, std::vector<Eigen::Vector3d>* points_world) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / spacing_m)));
  for (int i = 0; i <= steps; ++i)
    points_world->push_back(shape.ToWorld(from + (static_cast<double>(i) / steps) * (to - from)));
}

}  // namespace

std::vector<Eigen::Vector3d> PointsOn(const TerrainRegion& region, double spacing_m) {
  const RegionShape shape(region);
  const FlatPolygon& polygon = shape.polygon();
  std::vector<Eigen::Vector3d> points_world;
  for (std::size_t i = 0; i < polygon.num_edges(); ++i)
    AddLine(shape, polygon.start(i), polygon.end(i), spacing_m, &points_world);
  std::vector<double> crossings;
  for (double y = polygon.box().min().y() + 0.5 * spacing_m; y < polygon.box().max().y(); y += spacing_m) {
    crossings.clear();
    for (std::size_t i = 0; i < polygon.num_edges(); ++i) {
      const Eigen::Vector2d& a = polygon.start(i);
      const Eigen::Vector2d& b = polygon.end(i);
      if ((a.y() <= y) == (b.y() <= y)) continue;
      crossings.push_back(a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y())));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
      AddLine(shape, {crossings[i], y}, {crossings[i + 1], y}, spacing_m, &points_world);
  }
  return points_world;
}

RegionMesh MeshOf(const TerrainRegion& region) {
  const RegionShape shape(region);
  const FlatPolygon& polygon = shape.polygon();
  std::vector<double> cuts;
  for (std::size_t i = 0; i < polygon.num_edges(); ++i) cuts.push_back(polygon.start(i).y());
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  RegionMesh mesh;
  const auto add = [&](double x, double y) {
    mesh.vertices_world.push_back(shape.ToWorld({x, y}));
    return static_cast<std::uint32_t>(mesh.vertices_world.size() - 1);
  };
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double low_y = cuts[i], high_y = cuts[i + 1];
    const std::vector<Side> sides = SidesBetween(polygon, low_y, high_y);
    for (std::size_t j = 0; j + 1 < sides.size(); j += 2) {
      const Side& left = sides[j];
      const Side& right = sides[j + 1];
      const std::uint32_t corners[4] = {add(left.low_x, low_y), add(right.low_x, low_y),
                                        add(right.high_x, high_y), add(left.high_x, high_y)};
      if (right.low_x > left.low_x)
        mesh.triangles.insert(mesh.triangles.end(), {corners[0], corners[1], corners[2]});
      if (right.high_x > left.high_x)
        mesh.triangles.insert(mesh.triangles.end(), {corners[0], corners[2], corners[3]});
    }
  }
  return mesh;
}

}  // namespace terrace
