// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/repeated_patterns.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "test/every_target.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

/// A texture without repetitions, with stripes in columns [160, 240).
cv::Mat1b StripedImage(double period_px) {
  cv::Mat1b image = RenderPlane(320, 80, {0.0, 0.0, 0.0}).left;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 2.0);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 160; u < 240; ++u) {
      const double wave = std::sin(6.283185 * (u + 0.2 * v) / period_px);
      image(v, u) = cv::saturate_cast<std::uint8_t>(120 + (wave > 0 ? 40 : -40) + noise(random));
    }
  return image;
}

TEST(RepeatedPatternsTest, FindsStripesAndNothingElseOnEveryTarget) {
  for (const double period_px : {4.0, 6.5, 9.0, 14.0}) {
    const cv::Mat1b image = StripedImage(period_px);
    OnEveryTarget([&] {
      RepeatedPatterns patterns;
      patterns.Find(image);
      for (int v = 0; v < 80; v += 10) {
        EXPECT_EQ(patterns.NumPixels(v, 176, 224, 1), 48) << period_px << " row " << v;
        EXPECT_EQ(patterns.NumPixels(v, 0, 144, 1), 0) << period_px << " row " << v;
        EXPECT_EQ(patterns.NumPixels(v, 272, 320, 1), 0) << period_px << " row " << v;
      }
    });
  }
}

TEST(RepeatedPatternsTest, FindsStripesUpToTheEdgesOfAnImageOfAnyWidth) {
  for (int width = 40; width < 57; ++width) {
    cv::Mat1b image(16, width);
    for (int v = 0; v < 16; ++v)
      for (int u = 0; u < width; ++u) image(v, u) = u / 3 % 2 == 0 ? 80 : 160;
    RepeatedPatterns patterns;
    patterns.Find(image);
    EXPECT_EQ(patterns.NumPixels(8, 0, width, 1), width / 8 * 8) << width;
  }
}

TEST(RepeatedPatternsTest, CountsInImagesThatAreLarger) {
  RepeatedPatterns patterns;
  patterns.Find(StripedImage(9.0));
  EXPECT_EQ(patterns.NumPixels(101, 355, 440, 2), 85);
  EXPECT_EQ(patterns.NumPixels(101, 0, 288, 2), 0);
}

TEST(RepeatedPatternsTest, SaysNothingOfNoiseHorizontalStripesAndTinyImages) {
  std::mt19937 random(5);
  cv::Mat1b noise(64, 64), stripes(64, 64);
  for (int v = 0; v < 64; ++v)
    for (int u = 0; u < 64; ++u) noise(v, u) = random() % 256, stripes(v, u) = v / 4 % 2 == 0 ? 50 : 200;
  for (const cv::Mat1b& image : {noise, stripes, cv::Mat1b(noise, cv::Rect(0, 0, 8, 8)),
                                 cv::Mat1b(noise, cv::Rect(0, 0, 20, 9)), cv::Mat1b(4, 40, 7)}) {
    RepeatedPatterns patterns;
    patterns.Find(image);
    for (int v = 0; v < image.rows; ++v) EXPECT_EQ(patterns.NumPixels(v, 0, image.cols, 1), 0);
  }
}

}  // namespace
}  // namespace terrace
