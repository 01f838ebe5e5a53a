// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/well_seen.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

/// Looks straight down on the middle of a floor of 10 x 10 cells with two by two pixels a cell.
class WellSeenTest : public ::testing::Test {
 protected:
  void LookFrom(double height_m, std::uint16_t id = 7) {
    StereoCamera camera{20, 20, height_m / 0.02, height_m / 0.02, 9.5, 9.5, 0.1};
    Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
    T_world_left.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    T_world_left.translation() = Eigen::Vector3d(0.2, 0.2, height_m);
    labels_.data.resize(400, id);
    well_seen_.Add(labels_, camera, T_world_left);
  }
  long NumWellSeen() const {
    const CellsOfPolygons all = well_seen_.Cells();
    const std::vector<std::uint8_t>& seen = all.at(7).seen;
    return std::count(seen.begin(), seen.end(), 1);
  }

  static TrueScene Floor() {
    TrueScene scene;
    scene.polygons.push_back(
        Rectangle(7, "walkway", {0, 0, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 10, 10));
    return scene;
  }

  TrueScene scene_ = Floor();
  WellSeenCells well_seen_{scene_};
  Gray16Image labels_{20, 20, {}};
};

TEST_F(WellSeenTest, WantsTwoFrames) {
  LookFrom(1.0);
  EXPECT_EQ(NumWellSeen(), 0);
  LookFrom(1.0);
  EXPECT_EQ(NumWellSeen(), 100);
}

TEST_F(WellSeenTest, WantsFourPixelsInACell) {
  labels_.data.assign(400, 7);
  labels_.data[0] = 0;  // the corner at small x and large y
  LookFrom(1.0);
  LookFrom(1.0);
  EXPECT_EQ(NumWellSeen(), 99);
  EXPECT_EQ(well_seen_.Cells().at(7).seen[9], 0);
}

TEST_F(WellSeenTest, LooksNoFartherThanTwoAndAHalfMetres) {
  for (int frame = 0; frame < 5; ++frame) LookFrom(2.6);
  EXPECT_EQ(NumWellSeen(), 0);
  for (int frame = 0; frame < 2; ++frame) LookFrom(2.45);
  EXPECT_EQ(NumWellSeen(), 100);
}

TEST_F(WellSeenTest, CountsOnlyTheSurfaceThatThePixelShows) {
  LookFrom(1.0, 8);
  LookFrom(1.0, 8);
  EXPECT_EQ(NumWellSeen(), 0);
}

}  // namespace
}  // namespace terrace
