// SPDX-License-Identifier: BSD-3-Clause
#include "core/time.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(TimestampTest, RoundsMicrosecondsTowardsThePast) {
  EXPECT_EQ((Timestamp{1999}).utime(), 1);
  EXPECT_EQ((Timestamp{2000}).utime(), 2);
  EXPECT_EQ((Timestamp{-1}).utime(), -1);
  EXPECT_EQ(Timestamp::FromMicroseconds(7).ns, 7000);
}

TEST(TimestampTest, OrdersAndSubtractsInNanoseconds) {
  const Timestamp a{1'600'000'000'000'000'000};
  const Timestamp b = a + std::chrono::milliseconds(66);
  EXPECT_LT(a, b);
  EXPECT_EQ((b - a).count(), 66'000'000);
  EXPECT_DOUBLE_EQ(Seconds(b - a), 0.066);
}

}  // namespace
}  // namespace terrace
