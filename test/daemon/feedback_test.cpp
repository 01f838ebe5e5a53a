// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/feedback.h"

#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(FeedbackExchangeTest, GivesWhatAFrameTaughtTheFixedNumberOfFramesLater) {
  FeedbackExchange<std::optional<double>> exchange(2, true);
  EXPECT_FALSE(exchange.Take(0));
  exchange.Post(0, 0.1);
  EXPECT_FALSE(exchange.Take(1));
  exchange.Post(1, 0.2);
  EXPECT_EQ(exchange.Take(2), 0.1);
  exchange.Post(2, std::nullopt);
  EXPECT_EQ(exchange.Take(3), 0.2);
  EXPECT_FALSE(exchange.Take(4));
}

TEST(FeedbackExchangeTest, WaitsForAFrameThatIsStillBeingMapped) {
  FeedbackExchange<std::optional<double>> exchange(1, true);
  std::thread mapping([&] { exchange.Post(0, 0.3); });
  EXPECT_EQ(exchange.Take(1), 0.3);
  mapping.join();
}

TEST(FeedbackExchangeTest, NobodyWaitsAfterClosing) {
  FeedbackExchange<std::optional<double>> exchange(1, true);
  std::thread odometry([&] { EXPECT_FALSE(exchange.Take(5)); });
  exchange.Close();
  odometry.join();
}

TEST(FeedbackExchangeTest, SkipsAndCountsWhatIsLateWhereNobodyMayWait) {
  FeedbackExchange<std::optional<double>> exchange(1, false);
  EXPECT_FALSE(exchange.Take(0));
  EXPECT_FALSE(exchange.Take(1));  // frame 0 has not been mapped yet
  exchange.Post(0, 0.1);
  exchange.Post(1, 0.2);
  EXPECT_EQ(exchange.Take(2), 0.2);
  EXPECT_EQ(exchange.num_skipped(), 1);
}

}  // namespace
}  // namespace terrace
