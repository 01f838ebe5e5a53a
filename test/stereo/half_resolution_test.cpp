// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/half_resolution.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(HalfResolutionTest, TakesTheMeanOfEachBlockAndRepeatsAnOddEdge) {
  const cv::Mat1b image = (cv::Mat1b(3, 3) << 10, 20, 7, 30, 40, 9, 1, 3, 200);
  cv::Mat1b half;
  HalveImage(image, half);
  ASSERT_EQ(half.size(), cv::Size(2, 2));
  EXPECT_EQ(half(0, 0), 25);
  EXPECT_EQ(half(0, 1), 8);
  EXPECT_EQ(half(1, 0), 2);
  EXPECT_EQ(half(1, 1), 200);
}

TEST(HalfResolutionTest, DoublesASlantedPlaneExactlyInsideTheImage) {
  // Pixel (i, j) of the halved image is centred at (2 i + 0.5, 2 j + 0.5) of the full one.
  cv::Mat1f half(9, 11), full(17, 22);
  for (int j = 0; j < half.rows; ++j)
    for (int i = 0; i < half.cols; ++i)
      half(j, i) = static_cast<float>((8.0 + 0.1 * (2 * i + 0.5) + 0.2 * (2 * j + 0.5)) / 2.0);
  DoubleDisparity(half, full);
  for (int v = 1; v < 16; ++v)
    for (int u = 1; u < 21; ++u) EXPECT_NEAR(full(v, u), 8.0 + 0.1 * u + 0.2 * v, 1e-5) << u << ' ' << v;
}

TEST(HalfResolutionTest, DoublesASteepPlaneExactlyInsideTheImage) {
  cv::Mat1f half(30, 64), full(60, 128);
  for (int j = 0; j < half.rows; ++j)
    for (int i = 0; i < half.cols; ++i)
      half(j, i) = static_cast<float>((8.0 + 0.1 * (2 * i + 0.5) + 1.5 * (2 * j + 0.5)) / 2.0);
  SteepSurfaces steep;
  steep.Measure(half);
  DoubleDisparity(half, full, steep);
  for (int v = 1; v < 59; ++v)
    for (int u = 1; u < 127; ++u) EXPECT_NEAR(full(v, u), 8.0 + 0.1 * u + 1.5 * v, 1e-4) << u << ' ' << v;
}

TEST(HalfResolutionTest, NeitherMixesSurfacesNorFillsHoles) {
  cv::Mat1f half(4, 6, 5.0f), full(8, 12);
  for (int j = 0; j < 4; ++j) half(j, 4) = half(j, 5) = 10.0f;
  half(1, 1) = std::numeric_limits<float>::quiet_NaN();
  DoubleDisparity(half, full);
  for (int v = 0; v < 8; ++v)
    for (int u = 0; u < 12; ++u) {
      if (u / 2 == 1 && v / 2 == 1) {
        EXPECT_TRUE(std::isnan(full(v, u)));
      } else {
        EXPECT_EQ(full(v, u), u < 8 ? 10.0f : 20.0f) << u << ' ' << v;
      }
    }
}

}  // namespace
}  // namespace terrace
