// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/evidence_look.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "test/mapping/disparity_of_planes.h"

namespace terrace {
namespace {

constexpr float kNoise_px = 0.1F;

/// Looks at the plane of a level platform of 0.8 x 0.6 m, 0.2 m above a floor.
class Platform {
 public:
  static constexpr double kLow_x = 1.0, kHigh_x = 1.8, kHalf_y = 0.3, kHeight = 0.2;

  Platform() {
    world_.AddFloor(kLow_x, kHigh_x, -kHalf_y, kHalf_y, kHeight);
    grid_.Open({kLow_x - 0.3, -kHalf_y - 0.3}, {kHigh_x + 0.3, kHalf_y + 0.3});
  }
  void AddFloorBelow() { world_.AddFloor(-1, 5, -3, 3, 0); }
  PlaneWorld& world() { return world_; }
  EvidenceGrid& grid() { return grid_; }

  LookResult Look(int num_frames) {
    LookResult result;
    for (int i = 0; i < num_frames; ++i, ++frame_) {
      const PoseEstimate pose = LookFrom(frame_, 0.1 + 0.004 * frame_, 0.01 * (frame_ % 5), 0.9, 0, 0.5);
      const DisparityImage image = DisparityOf(world_, TestCamera(), pose, kNoise_px, &random_);
      const FrameView view{TestCamera(), pose.T_world_left, &image};
      const Plane plane{Eigen::Vector3d::UnitZ(), kHeight};
      const PlaneAxes axes{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
      const PlaneFrame frame(plane, Eigen::Vector3d(0, 0, kHeight), axes, plane.normal);
      result = EvidenceLook(view).At(plane, frame, 0.003, &grid_);
    }
    return result;
  }

 private:
  PlaneWorld world_;
  EvidenceGrid grid_;
  std::mt19937 random_{1};
  int frame_ = 0;
};

TEST(EvidenceLookTest, TheSurfaceEndsWherePixelsSeeThroughItsPlaneWithinTwoCentimetres) {
  Platform platform;
  platform.AddFloorBelow();
  platform.Look(12);
  // Along the middle, and across it: a pixel is 8 mm wide there, and three times as long.
  for (double x = 0.8; x < 2.0; x += 0.005) {
    const int cell = platform.grid().At({x, 0.005});
    const double inside = std::min(x - Platform::kLow_x, Platform::kHigh_x - x);
    if (inside > 0.02) {
      EXPECT_GE(cell, EvidenceGrid::kOn) << x;
    } else if (inside < -0.02) {
      EXPECT_LE(cell, 0) << x;
    }
  }
  for (double y = -0.5; y < 0.5; y += 0.005) {
    const int cell = platform.grid().At({1.405, y});
    const double inside = Platform::kHalf_y - std::abs(y);
    if (inside > 0.015) {
      EXPECT_GE(cell, EvidenceGrid::kOn) << y;
    } else if (inside < -0.015) {
      EXPECT_LE(cell, EvidenceGrid::kThrough) << y;
    }
  }
}

TEST(EvidenceLookTest, WhatHasNoDisparityBehindItIsNotSeenThrough) {
  Platform platform;
  platform.Look(12);
  EXPECT_GE(platform.grid().At({1.4, 0.0}), EvidenceGrid::kOn);
  // Nor does it stay as if it had never been looked at.
  for (const double y : {-0.45, -0.35, 0.35, 0.45}) {
    EXPECT_LT(platform.grid().At({1.4, y}), 0) << y;
    EXPECT_GT(platform.grid().At({1.4, y}), EvidenceGrid::kThrough) << y;
  }
}

TEST(EvidenceLookTest, WhatStandsBeforeThePlaneSaysNothingAboutIt) {
  Platform platform;
  platform.AddFloorBelow();
  platform.world().AddFaceTowardsMinusX(0.9, -0.1, 0.1, 0.0, 0.6);  // hides a part of the platform
  platform.Look(12);
  EXPECT_EQ(platform.grid().At({1.1, 0.0}), 0);
  EXPECT_GE(platform.grid().At({1.4, 0.25}), EvidenceGrid::kOn);
}

TEST(EvidenceLookTest, WhatHasLeftIsForgottenWithinHalfASecond) {
  Platform platform;
  platform.AddFloorBelow();
  platform.Look(60);
  EXPECT_GE(platform.grid().At({1.4, 0.0}), EvidenceGrid::kOn);
  platform.world().rectangles.erase(platform.world().rectangles.begin());
  constexpr int kHalfASecond = 10;  // frames at 20 Hz
  platform.Look(kHalfASecond);
  int num_left = 0;
  for (double x = Platform::kLow_x; x < Platform::kHigh_x; x += 0.01)
    for (double y = -Platform::kHalf_y; y < Platform::kHalf_y; y += 0.01)
      num_left += platform.grid().At({x, y}) >= EvidenceGrid::kOn;
  EXPECT_EQ(num_left, 0);
}

TEST(EvidenceLookTest, WhatWasSeenFromAfarOnlyFadesWhereNothingIsSeenFromNear) {
  Platform platform;
  platform.Look(12);  // there is no floor below: beyond the platform nothing has a disparity
  const auto set = [&](const Eigen::Vector2d& p, int evidence) {
    const auto [key, cell] = platform.grid().Locate(p);
    platform.grid().blocks().at(key).At(cell.x(), cell.y()) = static_cast<std::int8_t>(evidence);
  };
  const Eigen::Vector2d coarse(1.405, 0.355), fine(1.405, 0.405);
  set(coarse, 8);  // as eight looks from afar leave it
  set(fine, 32);   // as eight looks from near do
  platform.Look(24);
  EXPECT_LT(platform.grid().At(coarse), EvidenceGrid::kOn);
  EXPECT_EQ(platform.grid().At(fine), 32);
}

TEST(EvidenceLookTest, WhatWasSeenFromAfarOnlyFadesWhereItLiesJustBehindAnotherSurface) {
  for (const double above_m : {0.08, 0.3}) {
    Platform platform;
    platform.AddFloorBelow();
    platform.Look(1);
    const auto set = [&](const Eigen::Vector2d& p, int evidence) {
      const auto [key, cell] = platform.grid().Locate(p);
      platform.grid().blocks().at(key).At(cell.x(), cell.y()) = static_cast<std::int8_t>(evidence);
    };
    platform.world().AddFloor(1.2, 1.6, -0.1, 0.1, Platform::kHeight + above_m);
    const Eigen::Vector2d coarse(1.405, 0.005), fine(1.405, 0.025);
    set(coarse, 8);
    set(fine, 32);
    platform.Look(24);
    EXPECT_EQ(platform.grid().At(coarse) < EvidenceGrid::kOn, above_m < 0.1) << above_m;
    EXPECT_EQ(platform.grid().At(fine), 32) << above_m;
  }
}

TEST(EvidenceLookTest, APlaneSeenFromBehindGathersNothing) {
  Platform platform;
  platform.AddFloorBelow();
  const PoseEstimate pose = LookFrom(0, 0.1, 0, 0.1, 0, 0.0);  // below the platform's plane
  std::mt19937 random(1);
  const DisparityImage image = DisparityOf(platform.world(), TestCamera(), pose, kNoise_px, &random);
  const FrameView view{TestCamera(), pose.T_world_left, &image};
  const Plane plane{Eigen::Vector3d::UnitZ(), Platform::kHeight};
  const PlaneFrame frame(plane, {0, 0, Platform::kHeight}, AxesOf(plane.normal), plane.normal);
  const LookResult result = EvidenceLook(view).At(plane, frame, 0.003, &platform.grid());
  EXPECT_EQ(result.num_on, 0);
  EXPECT_EQ(result.num_through, 0);
}

}  // namespace
}  // namespace terrace
