// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/winner.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>
#include <hwy/aligned_allocator.h>

#include "test/every_target.h"

namespace terrace {
namespace {

/// One row of sums, written by disparity.
class Row {
 public:
  Row(int width, int n, std::uint8_t fill)
      : width_(width),
        n_(n),
        bytes_(hwy::AllocateAligned<std::uint8_t>((width + 15) / 16 * 16 * n)),
        first_((width + 15) / 16 * 16, 0) {
    std::fill(bytes_.get(), bytes_.get() + (width + 15) / 16 * 16 * n, fill);
  }
  std::uint8_t& operator()(int u, int d) { return bytes_[u * n_ + n_ - 1 - d]; }
  std::vector<float> Choose(const WinnerRules& rules) {
    std::vector<float> disparity(width_);
    WinnerChooser(rules).Choose({bytes_.get(), width_, n_, first_.data()}, disparity.data());
    return disparity;
  }

 private:
  int width_, n_;
  hwy::AlignedFreeUniquePtr<std::uint8_t[]> bytes_;
  std::vector<std::int16_t> first_;
};

TEST(WinnerTest, FindsWhatASlowSearchFindsOnEveryTarget) {
  for (const int n : {16, 32, 48, 64, 128, 192}) {
    std::mt19937 random(n);
    const int width = 203;
    Row row(width, n, 0);
    for (int u = 0; u < width; ++u)
      for (int d = 0; d < n; ++d) row(u, d) = static_cast<std::uint8_t>(20 + random() % 100);
    const WinnerRules rules{5, -1};
    OnEveryTarget([&] {
      const std::vector<float> found = row.Choose(rules);
      for (int u = 0; u < width; ++u) {
        int best = n - 1;
        for (int d = n - 1; d >= 0; --d)
          if (row(u, d) < row(u, best)) best = d;
        const int limit = row(u, best) + row(u, best) * 5 / 100;
        bool unique = true;
        for (int d = 0; d < n; ++d) unique = unique && (std::abs(d - best) <= 1 || row(u, d) > limit);
        if (!unique || best > u || u < 3) {
          ASSERT_TRUE(std::isnan(found[u])) << n << ' ' << u;
        } else {
          ASSERT_NEAR(found[u], best, 0.5) << n << ' ' << u;
        }
      }
    });
  }
}

TEST(WinnerTest, PutsTheParabolasLowestPointBetweenWholeDisparities) {
  Row row(40, 16, 200);
  for (int u = 0; u < 40; ++u) row(u, 4) = 40, row(u, 5) = 20, row(u, 6) = 30;
  EXPECT_FLOAT_EQ(row.Choose({}).at(20), 5.0f + 0.5f * (40 - 30) / (40 + 30 - 40));
}

TEST(WinnerTest, GivesAPixelOfTheRightImageToTheBetterOfTwoClaims) {
  Row row(40, 16, 200);
  for (int u = 0; u < 40; ++u) row(u, 3) = 20;
  row(30, 3) = 200, row(30, 10) = 30;  // claims pixel 20 of the right image, which belongs to 23
  const std::vector<float> found = row.Choose({});
  EXPECT_FLOAT_EQ(found[23], 3.0f);
  EXPECT_TRUE(std::isnan(found[30]));
}

TEST(WinnerTest, DistrustsASumThatMayHaveOverflowed) {
  Row row(20, 16, 255);
  EXPECT_TRUE(std::isnan(row.Choose({}).at(19)));
}

}  // namespace
}  // namespace terrace
