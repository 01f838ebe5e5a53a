// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_units.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "test/every_target.h"

namespace terrace {
namespace {

TEST(DisparityUnitsTest, KeepsDisparitiesToHalfAUnitOnEveryTarget) {
  constexpr int kOddWidth = 77;  // no multiple of any vector
  cv::Mat1f disparity(2, kOddWidth);
  for (int v = 0; v < 2; ++v)
    for (int u = 0; u < kOddWidth; ++u)
      disparity(v, u) =
          u % 5 == 3 ? std::numeric_limits<float>::quiet_NaN() : 0.01f + 3.3f * static_cast<float>(u + v);
  OnEveryTarget([&] {
    UnitImage units;
    units.Set(disparity);
    for (int v = 0; v < 2; ++v) {
      for (int u = 0; u < kOddWidth; ++u) {
        if (std::isnan(disparity(v, u))) {
          EXPECT_TRUE(std::isnan(units.Px(v, u)));
        } else {
          EXPECT_NEAR(units.Px(v, u), std::min(disparity(v, u), 255.0f), 0.5f / UnitImage::kUnitsPerPx);
        }
      }
      for (int i = 1; i <= UnitImage::kMargin; ++i) {
        EXPECT_EQ(units.Row(v)[-i], 0);
        EXPECT_EQ(units.Row(v)[kOddWidth - 1 + i], 0);
      }
    }
  });
}

TEST(DisparityUnitsTest, KnowsADisparityOfNothingFromAnUnknownOne) {
  UnitImage units;
  units.Set(cv::Mat1f(1, 40, 0.0f));
  for (int u = 0; u < 40; ++u) EXPECT_NEAR(units.Px(0, u), 0.0f, 1.0f / UnitImage::kUnitsPerPx);
  units.Set(cv::Mat1f(1, 40, -0.4f));
  for (int u = 0; u < 40; ++u) EXPECT_GT(units.Row(0)[u], 0);
}

}  // namespace
}  // namespace terrace
