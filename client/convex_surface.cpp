// SPDX-License-Identifier: BSD-3-Clause
#include "client/convex_surface.h"

#include <utility>

#include "client/box_section.h"
#include "client/convex_cover.h"
#include "client/convex_inflation.h"
#include "client/convex_ring.h"
#include "client/inset.h"
#include "core/check.h"
#include "core/plane_rings.h"

namespace terrace {
namespace {

ConvexSurface SurfaceOf(const TerrainQuery::Entry& entry, FlatRing ring) {
  ConvexSurface surface;
  surface.region_id = entry.region->id;
  surface.label = entry.region->label;
  const RegionShape& shape = *entry.shape;
  surface.T_world_plane.linear() << shape.axes_world().x, shape.axes_world().y, shape.normal_world();
  surface.T_world_plane.translation() = shape.centroid_world();
  const auto size = static_cast<Eigen::Index>(ring.size());
  surface.A.resize(size, 2);
  surface.b.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::Vector2d& from = ring[static_cast<std::size_t>(i)];
    const Eigen::Vector2d side = ring[static_cast<std::size_t>((i + 1) % size)] - from;
    const Eigen::Vector2d outward = Eigen::Vector2d(side.y(), -side.x()).normalized();
    surface.A.row(i) = outward.transpose();
    surface.b(i) = outward.dot(from);
  }
  surface.area_m2 = SignedArea(ring);
  surface.vertices = std::move(ring);
  return surface;
}

}  // namespace

std::vector<ConvexSurface> ConvexSurfaces(const TerrainQuery& query, const Eigen::AlignedBox3d& box_world,
                                          double inset_m, double min_area_m2, LabelSet labels) {
  std::vector<ConvexSurface> surfaces;
  for (const std::int64_t id : query.RegionsIn(box_world, labels)) {
    const TerrainQuery::Entry& entry = *query.Find(id);
    const FlatRing section = SectionOf(*entry.shape, box_world);
    if (section.empty()) continue;
    const FlatPolygon free = Within(*entry.shape->Inset({inset_m, inset_m, inset_m}), section);
    for (FlatRing& ring : ConvexCover(free, min_area_m2))
      surfaces.push_back(SurfaceOf(entry, std::move(ring)));
  }
  return surfaces;
}

std::optional<ConvexSurface> LargestConvexAround(const TerrainQuery& query,
                                                 const Eigen::Vector3d& point_world, double inset_m,
                                                 std::size_t max_vertices, LabelSet labels) {
  TERRACE_CHECK(max_vertices >= 3, max_vertices);
  constexpr double kNear_m = 0.05;
  FootSpec anything;
  anything.radius_m = inset_m;
  anything.clear_drop_m = anything.clear_rise_m = 0.0;
  anything.max_slope_rad = M_PI;
  anything.min_confidence = 0.0;
  anything.allow_predicted = true;
  anything.labels = labels;
  const auto ground = query.NearestFoothold(point_world, kNear_m, kNear_m, anything);
  if (!ground) return std::nullopt;
  const TerrainQuery::Entry& entry = *query.Find(ground->support.region_id);
  const auto free = entry.shape->Inset({inset_m, inset_m, inset_m});
  Eigen::Vector2d seed = entry.shape->ToPlane(ground->support.point_world);
  // A point on the border is taken a little further in the direction in which it was found.
  constexpr double kInward_m = 1e-3;
  const Eigen::Vector2d asked = entry.shape->ToPlane(point_world);
  if ((seed - asked).norm() > 1e-9) seed += kInward_m * (seed - asked).normalized();
  FlatRing ring = Inflate(*free, seed, {.keep_seed = true, .worth = {}});
  if (ring.empty()) return std::nullopt;
  return SurfaceOf(entry, WithFewerVertices(std::move(ring), max_vertices, seed));
}

}  // namespace terrace
