// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/census.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "test/every_target.h"

namespace terrace {
namespace {

cv::Mat1b RandomImage(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat1b image(height, width);
  for (auto& pixel : image) pixel = static_cast<std::uint8_t>(random() % 256);
  return image;
}

int SlowBit(const cv::Mat1b& image, int u, int v, const CensusPair& p) {
  const auto at = [&](int du, int dv) {
    return image(std::clamp(v + dv, 0, image.rows - 1), std::clamp(u + du, 0, image.cols - 1));
  };
  return at(p.du1, p.dv1) > at(p.du2, p.dv2) ? 1 : 0;
}

TEST(CensusTest, ComparesThePixelsOfEachPairOnEveryTarget) {
  const cv::Mat1b image = RandomImage(71, 13, 1);
  for (const auto& pairs : {Census5x5(), Census9x7(), CensusMixed()})
    OnEveryTarget([&] {
      CensusImage census;
      census.Compute(image, pairs);
      for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u)
          for (int bit = 0; bit < 32; ++bit) {
            const int expected = bit < static_cast<int>(pairs.size()) ? SlowBit(image, u, v, pairs[bit]) : 0;
            ASSERT_EQ((census.Row(v, bit / 8)[u] >> (bit % 8)) & 1, expected) << u << ' ' << v << ' ' << bit;
          }
    });
}

TEST(CensusTest, HasNoMoreThanThirtyTwoBits) {
  EXPECT_EQ(Census5x5().size(), 24u);
  EXPECT_EQ(Census9x7().size(), 31u);
  EXPECT_EQ(CensusMixed().size(), 32u);
}

}  // namespace
}  // namespace terrace
