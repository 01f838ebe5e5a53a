// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/doubtful_tiles.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

constexpr int kMaxSum = 90;
constexpr float kLast = 30.0f;

/// The tiles of an image with disparities and best sums as `disparity_of` and `sum_of` say.
template <typename DisparityOf, typename SumOf>
DoubtfulTiles TilesOf(const cv::Size& size, const DisparityOf& disparity_of, const SumOf& sum_of) {
  DoubtfulTiles tiles;
  tiles.Begin(size);
  std::vector<float> disparity(size.width);
  std::vector<std::uint8_t> sums(size.width);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) disparity[u] = disparity_of(u, v), sums[u] = sum_of(u, v);
    tiles.AddRow(v, disparity.data(), sums.data(), kMaxSum, kLast);
  }
  return tiles;
}

TEST(DoubtfulTilesTest, ForgetsTilesWhereAThirdIsPoorOrTheLast) {
  // 20 x 12: three columns of tiles, the last four wide; two rows of them.
  const auto disparity_of = [](int u, int v) {
    if (u < 8 && v < 8) return v < 3 ? kLast : 10.0f;  // 24 of 64
    return u >= 18 ? kUnknownDisparity : 10.0f;
  };
  const auto sum_of = [](int u, int v) {
    if (u >= 8 && u < 16 && v >= 8) return static_cast<std::uint8_t>(u % 2 == 0 ? 200 : 20);  // half of them
    if (u >= 8 && u < 16 && v == 0) return static_cast<std::uint8_t>(200);                    // 8 of 64
    return static_cast<std::uint8_t>(20);
  };
  const DoubtfulTiles tiles = TilesOf({20, 12}, disparity_of, sum_of);
  cv::Mat1f disparity(24, 40, 7.0f);
  tiles.Forget(2, disparity);
  for (int v = 0; v < 24; ++v)
    for (int u = 0; u < 40; ++u) {
      const bool doubtful = (u < 16 && v < 16) || (u >= 16 && u < 32 && v >= 16);
      EXPECT_EQ(std::isnan(disparity(v, u)), doubtful) << u << " " << v;
    }
  EXPECT_NEAR(tiles.share(), (64 + 32) / 240.0, 1e-9);
  EXPECT_NEAR(tiles.share_at_limit(), 24 / 240.0, 1e-9);
}

TEST(DoubtfulTilesTest, ForgetsTilesWhereHardlyAnyIsKnown) {
  // Nine of 64 are known in the left tile, seven in the right one.
  const DoubtfulTiles tiles = TilesOf(
      {16, 8},
      [](int u, int v) {
        return v == 0 && (u < 8 || u > 8) ? 5.0f : v == 1 && u == 0 ? 5.0f : kUnknownDisparity;
      },
      [](int, int) { return std::uint8_t{20}; });
  cv::Mat1f disparity(8, 16, 7.0f);
  tiles.Forget(1, disparity);
  EXPECT_FALSE(std::isnan(disparity(4, 4)));
  EXPECT_TRUE(std::isnan(disparity(4, 12)));
  EXPECT_EQ(tiles.share(), 0.5);
  EXPECT_EQ(tiles.share_at_limit(), 0.0);
}

}  // namespace
}  // namespace terrace
