// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/floor_check.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace terrace {
namespace {

const Eigen::Vector3d kImageUp = -Eigen::Vector3d::UnitY();
const Eigen::Vector3d kLeftIsUp =
    -Eigen::Vector3d::UnitX();  // of a camera that is rolled clockwise by 90 deg

/// Points of a plane `below_m` under a camera to which `up` is up, ahead of it, with errors of a centimetre.
void AddFloor(const Eigen::Vector3d& up, double below_m, int count, std::mt19937* random,
              std::vector<Eigen::Vector3d>* points) {
  std::uniform_real_distribution<double> ahead(0.6, 3.0), aside(-1.0, 1.0);
  std::normal_distribution<double> error(0.0, 0.01);
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(up);
  for (int i = 0; i < count; ++i)
    points->push_back(Eigen::Vector3d::UnitZ() * ahead(*random) + aside(*random) * right -
                      (below_m + error(*random)) * up);
}

/// A wall ahead.
void AddWall(int count, std::mt19937* random, std::vector<Eigen::Vector3d>* points) {
  std::uniform_real_distribution<double> aside(-0.4, 0.4);
  for (int i = 0; i < count; ++i) points->emplace_back(aside(*random), aside(*random), 3.0);
}

TEST(FloorCheckTest, ConfirmsABodyUnderAPortraitCameraByTheFloor) {
  for (const unsigned seed : {101u, 102u, 103u}) {
    std::mt19937 random(seed);
    std::vector<Eigen::Vector3d> points;
    AddFloor(kLeftIsUp, 0.5, 150, &random, &points);
    AddWall(80, &random, &points);
    EXPECT_NEAR(FloorShare(points, kLeftIsUp), 150.0 / 230.0, 0.05);
    EXPECT_TRUE(FloorConfirmsBody(points, kLeftIsUp, kImageUp));
  }
}

TEST(FloorCheckTest, LeavesItOpenWhereFloorAndSideWallCannotBeToldApart) {
  std::mt19937 random(104);
  std::vector<Eigen::Vector3d> points;
  AddFloor(kLeftIsUp, 0.9, 120, &random, &points);  // a wall on the right of a level camera
  AddFloor(kImageUp, 0.5, 120, &random, &points);
  // Nothing is seen behind either.
  std::erase_if(points, [](const Eigen::Vector3d& p) { return p.x() > 0.93 || p.y() > 0.53; });
  EXPECT_GT(FloorShare(points, kLeftIsUp), 0.3);
  EXPECT_GT(FloorShare(points, kImageUp), 0.3);
  EXPECT_FALSE(FloorConfirmsBody(points, kLeftIsUp, kImageUp));
}

TEST(FloorCheckTest, TakesNoWallAheadNoCeilingAndNoTableForAFloor) {
  std::mt19937 random(105);
  std::vector<Eigen::Vector3d> wall, ceiling, table;
  AddWall(200, &random, &wall);
  EXPECT_EQ(FloorShare(wall, kImageUp), 0.0);
  AddFloor(kImageUp, -1.0, 200, &random, &ceiling);
  EXPECT_EQ(FloorShare(ceiling, kImageUp), 0.0);
  AddFloor(kImageUp, 0.3, 100, &random, &table);
  AddFloor(kImageUp, 1.0, 60, &random, &table);
  EXPECT_LT(FloorShare(table, kImageUp), 0.5) << "what lies beneath counts against it";
  EXPECT_EQ(FloorShare({}, kImageUp), 0.0);
}

TEST(FloorCheckTest, WantsTheFloorWithin15DegOfLevel) {
  for (const double tilt_deg : {10.0, 25.0}) {
    std::mt19937 random(106);
    std::vector<Eigen::Vector3d> points;
    AddFloor(kImageUp, 0.5, 200, &random, &points);
    const Eigen::Vector3d up =
        Eigen::AngleAxisd(tilt_deg * M_PI / 180.0, Eigen::Vector3d::UnitZ()) * kImageUp;
    EXPECT_EQ(FloorShare(points, up) > 0.5, tilt_deg < 15.0) << tilt_deg;
  }
}

}  // namespace
}  // namespace terrace
