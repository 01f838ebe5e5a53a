// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/flat_fringes.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "stereo/half_resolution.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

constexpr int kFringeWidth = 200, kFringeHeight = 120;
constexpr int kEdge_u = 120;  // textured from here on to the right

/// A textured surface on the right, flat sky on the left; sensor noise on both.
cv::Mat1b SurfaceBeforeSky() {
  cv::Mat1b image(kFringeHeight, kFringeWidth);
  cv::RNG random(7);
  for (int v = 0; v < kFringeHeight; ++v)
    for (int u = 0; u < kFringeWidth; ++u)
      image(v, u) =
          static_cast<std::uint8_t>(u < kEdge_u ? 140 + random.uniform(-1, 2) : 40 + random.uniform(0, 60));
  return image;
}

struct Matched {
  cv::Mat1b image;
  cv::Mat1f disparity{cv::Mat1f(kFringeHeight, kFringeWidth, 30.0f)};
  cv::Mat1f sigma{cv::Mat1f(kFringeHeight, kFringeWidth, 0.1f)};

  void Forget() {
    cv::Mat1b half;
    HalveImage(image, half);
    ForgetFlatFringes(image, half, disparity, sigma);
  }
};

TEST(FlatFringesTest, TakesTheFringeThatMatchingCarriesIntoTheSky) {
  constexpr int kFringe_px = 16;
  Matched matched{SurfaceBeforeSky()};
  matched.disparity.colRange(0, kEdge_u - kFringe_px) = kUnknownDisparity;
  matched.sigma.colRange(0, kEdge_u - kFringe_px) = kUnknownDisparity;
  matched.Forget();
  int num_beyond = 0;
  for (int v = 0; v < kFringeHeight; ++v) {
    for (int u = 0; u < kEdge_u; ++u) num_beyond += !std::isnan(matched.disparity(v, u));
    for (int u = kEdge_u; u < kFringeWidth; ++u) ASSERT_EQ(matched.disparity(v, u), 30.0f) << u << ' ' << v;
  }
  EXPECT_LE(num_beyond, kFringeHeight / 2);  // half a pixel in each row
  EXPECT_TRUE(std::isnan(matched.sigma(60, kEdge_u - kFringe_px / 2)));
}

TEST(FlatFringesTest, LeavesAFlatPlaceWithTextureAllAroundIt) {
  Matched matched{SurfaceBeforeSky()};
  matched.image.colRange(0, 30) = SurfaceBeforeSky().colRange(kEdge_u, kEdge_u + 30);
  matched.image.rowRange(0, 20).setTo(20);
  for (int u = 0; u < kFringeWidth; u += 2) matched.image(cv::Rect(u, 0, 1, 20)).setTo(90);
  matched.Forget();
  EXPECT_EQ(cv::countNonZero(matched.disparity == 30.0), kFringeWidth * kFringeHeight);
}

TEST(FlatFringesTest, LeavesAFlatWallThatHasHoles) {
  Matched matched{SurfaceBeforeSky()};
  const cv::Rect hole(40, 40, 8, 8);
  matched.disparity(hole) = kUnknownDisparity;
  matched.sigma(hole) = kUnknownDisparity;
  matched.Forget();
  EXPECT_EQ(cv::countNonZero(matched.disparity == 30.0), kFringeWidth * kFringeHeight - hole.area());
}

TEST(FlatFringesTest, LeavesAWallThatGoesOnFlatBesideWhatIsUnknown) {
  Matched matched{SurfaceBeforeSky()};
  // Hidden by something, say; the texture is farther from there than matching reaches.
  matched.disparity.colRange(0, 40) = kUnknownDisparity;
  matched.sigma.colRange(0, 40) = kUnknownDisparity;
  matched.Forget();
  EXPECT_EQ(cv::countNonZero(matched.disparity == 30.0), (kFringeWidth - 40) * kFringeHeight);
}

}  // namespace
}  // namespace terrace
