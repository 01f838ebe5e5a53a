// SPDX-License-Identifier: BSD-3-Clause
#include "tools/surface_raster.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// An upright square of 2 m edge that faces the origin from x = distance.
TerrainRegion SquareAhead(double distance) {
  TerrainRegion region;
  region.plane_world = {-Eigen::Vector3d::UnitX(), -distance};
  region.outline_world = {{distance, 1, -1}, {distance, -1, -1}, {distance, -1, 1}, {distance, 1, 1}};
  return region;
}

Eigen::Isometry3d LookingAlongX() {
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  T_world_left.linear().col(0) = -Eigen::Vector3d::UnitY();
  T_world_left.linear().col(1) = -Eigen::Vector3d::UnitZ();
  T_world_left.linear().col(2) = Eigen::Vector3d::UnitX();
  return T_world_left;
}

const StereoCamera kCamera{100, 100, 50.0, 50.0, 50.0, 50.0, 0.1};

TEST(SurfaceRasterTest, ShowsTheNearerOfTwoSurfacesInAnyOrder) {
  for (const bool far_first : {true, false}) {
    SurfaceRaster raster(100, 100, Projection::OfCamera(kCamera, LookingAlongX()));
    raster.Draw(SquareAhead(far_first ? 4.0 : 2.0), far_first ? 4 : 2);
    raster.Draw(SquareAhead(far_first ? 2.0 : 4.0), far_first ? 2 : 4);
    EXPECT_EQ(raster.region_at(50, 50), 2);
    EXPECT_EQ(raster.region_at(73, 50), 2);  // the edge of the near one is at 50 + 50 * 1 / 2
    EXPECT_EQ(raster.region_at(77, 50), -1);
  }
}

TEST(SurfaceRasterTest, LeavesOutHolesAndBacks) {
  SurfaceRaster raster(100, 100, Projection::OfCamera(kCamera, LookingAlongX()));
  TerrainRegion region = SquareAhead(2.0);
  region.holes_world = {{{2, 0.2, -0.2}, {2, 0.2, 0.2}, {2, -0.2, 0.2}, {2, -0.2, -0.2}}};
  raster.Draw(region, 1);
  EXPECT_EQ(raster.region_at(50, 50), -1);
  EXPECT_EQ(raster.region_at(60, 50), 1);
  TerrainRegion back = SquareAhead(1.0);
  back.plane_world = {Eigen::Vector3d::UnitX(), 1.0};
  raster.Draw(back, 3);
  EXPECT_EQ(raster.region_at(60, 50), 1);
}

TEST(SurfaceRasterTest, CutsAFloorThatPassesUnderTheCamera) {
  SurfaceRaster raster(100, 100, Projection::OfCamera(kCamera, LookingAlongX()));
  TerrainRegion floor;
  floor.plane_world = {Eigen::Vector3d::UnitZ(), -0.5};
  floor.outline_world = {{-5, -5, -0.5}, {5, -5, -0.5}, {5, 5, -0.5}, {-5, 5, -0.5}};
  raster.Draw(floor, 7);
  EXPECT_EQ(raster.region_at(50, 99), 7);
  EXPECT_EQ(raster.region_at(50, 56), 7);  // 5 m ahead is 5 px below the horizon
  EXPECT_EQ(raster.region_at(50, 53), -1);
}

TEST(SurfaceRasterTest, ParallelProjectionKeepsLengths) {
  Projection plan = Projection::Along(-Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY());
  plan.fx = plan.fy = 10.0;
  EXPECT_LT((plan.Pixel({3, 0, 7}) - Eigen::Vector2d(30, 0)).norm(), 1e-9);
  EXPECT_LT((plan.Pixel({0, 2, -1}) - Eigen::Vector2d(0, -20)).norm(), 1e-9);
}

}  // namespace
}  // namespace terrace
