// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/steep_surfaces.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "stereo/disparity_units.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

constexpr int kRampWidth = 128, kRampHeight = 48;

/// Disparities of each row, with what matching adds to them: whole rows are off, single pixels, some unknown.
SteepSurfaces Measured(const std::function<double(int v)>& disparity_of_row, double noise_px = 0.3) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, noise_px);
  cv::Mat1f disparity(kRampHeight, kRampWidth);
  for (int v = 0; v < kRampHeight; ++v) {
    const double row = disparity_of_row(v) + noise(random);
    for (int u = 0; u < kRampWidth; ++u)
      disparity(v, u) = random() % 8 == 0 ? kUnknownDisparity : static_cast<float>(row + noise(random));
  }
  SteepSurfaces steep;
  steep.Measure(disparity);
  return steep;
}

/// [px per row], each pixel of a row.
std::vector<double> SlopesOf(const SteepSurfaces& steep, int v, int scale = 1) {
  std::vector<std::int16_t> units(kRampWidth * scale + 64);
  if (!steep.SlopesOfRow(v, scale, kRampWidth * scale, units.data()))
    return std::vector<double>(kRampWidth * scale);
  std::vector<double> slopes;
  for (int u = 0; u < kRampWidth * scale; ++u)
    slopes.push_back(static_cast<double>(units[u]) / UnitImage::kUnitsPerPx);
  return slopes;
}

TEST(SteepSurfacesTest, FindsHowQuicklyANoisyTreadRises) {
  for (const double slope : {0.7, -1.0, 2.0}) {
    const SteepSurfaces steep = Measured([&](int v) { return 100.0 + slope * (v - 20); });
    int right = 0;
    for (int v = 4; v < kRampHeight - 4; ++v)
      for (const double found : SlopesOf(steep, v)) right += std::abs(found - slope) < 0.25;
    EXPECT_GT(right, 0.9 * (kRampHeight - 8) * kRampWidth) << slope;
  }
}

TEST(SteepSurfacesTest, LeavesFloorsAndStepsAlone) {
  const SteepSurfaces floor = Measured([](int v) { return 10.0 + 0.2 * v; }, 0.1);
  const SteepSurfaces step = Measured([](int v) { return v < 24 ? 20.0 : 28.0; }, 0.1);
  const SteepSurfaces steps = Measured([](int v) { return 20.0 + 4.0 * (v / 8); }, 0.1);
  for (int v = 0; v < kRampHeight; ++v)
    for (const SteepSurfaces* steep : {&floor, &step, &steps}) {
      const std::vector<double> slopes = SlopesOf(*steep, v);
      EXPECT_EQ(std::count(slopes.begin(), slopes.end(), 0.0), kRampWidth) << v;
    }
}

TEST(SteepSurfacesTest, EndsWhereTheTreadDoes) {
  // A riser, the tread before it, and the next riser's upper part below the tread's edge.
  const SteepSurfaces steep =
      Measured([](int v) { return v < 16   ? 20.0
                                  : v < 32 ? 20.0 + 0.9 * (v - 15)
                                           : 34.4; }, 0.1);
  for (int v = 0; v < kRampHeight; ++v) {
    const std::vector<double> slopes = SlopesOf(steep, v);
    const double mean = std::accumulate(slopes.begin(), slopes.end(), 0.0) / kRampWidth;
    if (v < 14 || v > 33) {
      EXPECT_EQ(mean, 0.0) << v;
    }
    if (v > 17 && v < 30) {
      EXPECT_NEAR(mean, 0.9, 0.15) << v;
    }
  }
}

TEST(SteepSurfacesTest, HasTheSameSlopesInALargerImage) {
  const SteepSurfaces steep = Measured([](int v) { return 20.0 + v; }, 0.1);
  for (int v = 0; v < kRampHeight; ++v) {
    const std::vector<double> once = SlopesOf(steep, v), twice = SlopesOf(steep, 2 * v + 1, 2);
    for (int u = 0; u < kRampWidth; ++u) {
      EXPECT_EQ(once[u], twice[2 * u]);
      EXPECT_EQ(once[u], twice[2 * u + 1]);
    }
  }
}

TEST(SteepSurfacesTest, HasNoneBeforeAnythingIsMeasured) {
  std::int16_t slopes[64];
  EXPECT_FALSE(SteepSurfaces().SlopesOfRow(0, 1, 64, slopes));
}

}  // namespace
}  // namespace terrace
