// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/region_census.h"

#include <gtest/gtest.h>

#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

TEST(RegionCensusTest, CountsSmallAndNarrowRegionsAsSlivers) {
  TrueScene scene;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  scene.polygons.push_back(Rectangle(1, "walkway", {0, 0, 0}, x, y, 25, 25));   // a square metre
  scene.polygons.push_back(Rectangle(2, "wall", {2, 0, 0}, x, y, 5, 6));        // 0.048 m^2
  scene.polygons.push_back(Rectangle(3, "wall", {3, 0, 0}, x, y, 100, 1));      // 4 m x 4 cm
  scene.polygons.push_back(Rectangle(4, "walkway", {8, 0, 0}, x, y, 100, 2));   // 4 m x 8 cm
  scene.polygons.push_back(Rectangle(5, "walkway", {14, 0, 0}, x, y, 25, 25));  // predicted
  TerrainMap map = MapOf(scene);
  map = WithRegion(map, 2, [](TerrainRegion& region) { region.label = TerrainLabel::kUnknown; });
  map = WithRegion(map, 5, [](TerrainRegion& region) { region.source = RegionSource::kPredicted; });
  const RegionCensus census = CountRegions(map);
  EXPECT_EQ(census.count, 4);
  EXPECT_EQ(census.num_slivers, 2);
  EXPECT_EQ(census.num_unknown, 1);
  EXPECT_NEAR(census.area_m2, 1.0 + 0.048 + 0.16 + 0.32, 1e-9);
  EXPECT_NEAR(census.sliver_pct(), 50.0, 1e-9);
  EXPECT_EQ(CountRegions({}).sliver_pct(), 0.0);
}

}  // namespace
}  // namespace terrace
