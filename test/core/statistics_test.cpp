// SPDX-License-Identifier: BSD-3-Clause
#include "core/statistics.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(SeriesTest, GivesNearestRankQuantiles) {
  Series series;
  for (int i = 100; i >= 1; --i) series.Add(i);
  const Quantiles q = series.quantiles();
  EXPECT_EQ(q.p50, 50);
  EXPECT_EQ(q.p90, 90);
  EXPECT_EQ(q.p99, 99);
  EXPECT_EQ(q.max, 100);
  EXPECT_DOUBLE_EQ(series.mean(), 50.5);
}

TEST(SeriesTest, KeepsTheNewestWithinItsCapacityAndTheMaximumOfAll) {
  Series series(3);
  for (const double v : {9.0, 1.0, 2.0, 3.0}) series.Add(v);
  EXPECT_EQ(series.count(), 4);
  EXPECT_EQ(series.newest().size(), 3u);
  EXPECT_EQ(series.quantiles().p99, 3.0);
  EXPECT_EQ(series.quantiles().max, 9.0);
}

TEST(QuantileTest, IsZeroOfNothing) { EXPECT_EQ(Quantile({}, 0.5), 0.0); }

}  // namespace
}  // namespace terrace
