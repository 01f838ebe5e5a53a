// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/polygon_revision.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace terrace {
namespace {

double AreaOf(const Ring& ring) {
  Eigen::Vector3d twice = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i)
    twice += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
  return 0.5 * twice.norm();
}

TEST(PolygonRevisionTest, AreaIsThatOfItsRingsAlsoWhenThePlaneHasTurnedSinceTheAxesWereLaid) {
  Surface surface;
  surface.origin_world = {1.0, 2.0, 0.5};
  surface.anchor_normal = Eigen::Vector3d::UnitZ();
  surface.axes = AxesOf(surface.anchor_normal);
  surface.plane_world.normal = Eigen::Vector3d(0.14, 0.0, 1.0).normalized();
  surface.plane_world.offset_m = surface.plane_world.normal.dot(surface.origin_world);
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.4, 0.4}) surface.moments.Add(1e4, {x, y, -0.14 * x});
  TracedPiece piece;
  piece.outline = {{-0.5, -0.4}, {0.5, -0.4}, {0.5, 0.4}, {-0.5, 0.4}};
  piece.area_m2 = 0.8;
  const Polygon polygon = MakePolygon(1, surface, piece, Timestamp{});
  EXPECT_NEAR(polygon.area_m2, AreaOf(polygon.outline_world), 1e-9);
  EXPECT_GT(polygon.area_m2, 0.806);
  for (const Eigen::Vector3d& corner : polygon.outline_world)
    EXPECT_NEAR(polygon.plane_world.SignedDistance(corner), 0.0, 1e-12);
}

}  // namespace
}  // namespace terrace
