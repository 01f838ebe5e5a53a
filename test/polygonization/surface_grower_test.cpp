// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_grower.h"

#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "core/angles.h"

namespace terrace {
namespace {

constexpr double kCell_m = 0.32;
constexpr int kAlong = 3, kAcross = 5;

/// A patch in the middle of its cell that rises along x by the angle.
Patch PatchAt(const Eigen::Vector3d& centre_world, double angle_rad) {
  const Eigen::Vector3d normal(-std::sin(angle_rad), 0.0, std::cos(angle_rad));
  Patch patch;
  patch.plane_world = {normal, normal.dot(centre_world)};
  for (const double x : {-0.1, 0.0, 0.1})
    for (const double y : {-0.1, 0.0, 0.1}) patch.moments.Add(1e6, {x, y, x * std::tan(angle_rad)});
  patch.low = {-0.1F, -0.1F, -0.05F};
  patch.high = {0.1F, 0.1F, 0.05F};
  patch.area_m2 = 0.04;
  patch.noise_m = patch.most_noise_m = 0.001;
  return patch;
}

/// Patches in a row of cells on one plane that rises along x by `slope_rad`; each of them leans as told.
PatchUpdate Slope(double slope_rad, const std::function<double(int x, int y)>& angle_rad) {
  PatchUpdate update;
  for (int x = 0; x < kAlong; ++x) {
    for (int y = 0; y < kAcross; ++y) {
      const Eigen::Vector3d centre(kCell_m * x, kCell_m * y, kCell_m * x * std::tan(slope_rad));
      update.cells.push_back({{x, y, 0}, centre, {PatchAt(centre, angle_rad(x, y))}});
    }
  }
  return update;
}

class SurfaceGrowerTest : public testing::Test {
 protected:
  SurfaceGrowerTest() {
    config_.max_gap_m = 0.2;
    grower_.Grow(Slope(kSlope_rad, [](int, int) { return kSlope_rad; }));
  }

  SurfaceId SurfaceAt(int x, int y) const { return store_.At({{x, y, 0}, 0}).surface; }

  static inline const double kSlope_rad = Radians(15.0);
  MergingConfig config_;
  SurfaceStore store_;
  SurfaceGrower grower_{config_, &store_};
};

TEST_F(SurfaceGrowerTest, PatchesInOnePlaneAreOneSurface) {
  for (int x = 0; x < kAlong; ++x)
    for (int y = 0; y < kAcross; ++y) EXPECT_EQ(SurfaceAt(x, y), SurfaceAt(0, 0)) << x << ' ' << y;
}

TEST_F(SurfaceGrowerTest, PatchesThatLeanTheSameWayLeaveTogether) {
  // A tread in the middle of a flight that was a slope from afar.
  grower_.Grow(Slope(kSlope_rad, [](int x, int) { return x == 1 ? 0.0 : kSlope_rad; }));
  for (int y = 0; y < kAcross; ++y) {
    EXPECT_EQ(SurfaceAt(1, y), SurfaceAt(1, 0)) << y;
    EXPECT_NE(SurfaceAt(1, y), SurfaceAt(0, y)) << y;
  }
  EXPECT_NEAR(store_.surfaces().at(SurfaceAt(1, 0)).plane_world.normal.z(), 1.0, 1e-9);
}

TEST_F(SurfaceGrowerTest, TheyStayApartWhenTheyAreSeenAgain) {
  const PatchUpdate update = Slope(kSlope_rad, [](int x, int) { return x == 1 ? 0.0 : kSlope_rad; });
  grower_.Grow(update);
  const SurfaceId tread = SurfaceAt(1, 0), slope = SurfaceAt(0, 0);
  grower_.Grow(update);
  EXPECT_EQ(SurfaceAt(1, 0), tread);
  EXPECT_EQ(SurfaceAt(0, 0), slope);
}

TEST_F(SurfaceGrowerTest, APatchThatLeansAloneStays) {
  grower_.Grow(
      Slope(kSlope_rad, [](int x, int y) { return kSlope_rad - (x == 1 && y == 2 ? Radians(5.0) : 0.0); }));
  EXPECT_EQ(SurfaceAt(1, 2), SurfaceAt(0, 0));
}

TEST_F(SurfaceGrowerTest, PatchesThatLeanThisWayAndThatStay) {
  grower_.Grow(
      Slope(kSlope_rad, [](int x, int y) { return kSlope_rad + Radians((x + y) % 2 ? 5.0 : -5.0); }));
  for (int x = 0; x < kAlong; ++x)
    for (int y = 0; y < kAcross; ++y) EXPECT_EQ(SurfaceAt(x, y), SurfaceAt(0, 0)) << x << ' ' << y;
}

}  // namespace
}  // namespace terrace
