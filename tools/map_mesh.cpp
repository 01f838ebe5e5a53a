// SPDX-License-Identifier: BSD-3-Clause
#include "tools/map_mesh.h"

#include <algorithm>
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

}  // namespace

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
