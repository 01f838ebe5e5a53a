// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/feedback.h"

#include <thread>

#include <gtest/gtest.h>

namespace terrace {
namespace {

Feedback Hint(double sigma_rad) {
  Feedback feedback;
  feedback.gravity = GravityHint{.sigma_rad = sigma_rad};
  return feedback;
}

TEST(FeedbackExchangeTest, GivesWhatAFrameTaughtTheFixedNumberOfFramesLater) {
  FeedbackExchange exchange(2);
  EXPECT_FALSE(exchange.Take(0).gravity);
  exchange.Post(0, Hint(0.1));
  EXPECT_FALSE(exchange.Take(1).gravity);
  exchange.Post(1, Hint(0.2));
  EXPECT_EQ(exchange.Take(2).gravity->sigma_rad, 0.1);
  exchange.Post(2, {});
  EXPECT_EQ(exchange.Take(3).gravity->sigma_rad, 0.2);
  EXPECT_FALSE(exchange.Take(4).gravity);
}

TEST(FeedbackExchangeTest, WaitsForAFrameThatIsStillBeingMapped) {
  FeedbackExchange exchange(1);
  std::thread mapping([&] { exchange.Post(0, Hint(0.3)); });
  EXPECT_EQ(exchange.Take(1).gravity->sigma_rad, 0.3);
  mapping.join();
}

TEST(FeedbackExchangeTest, NobodyWaitsAfterClosing) {
  FeedbackExchange exchange(1);
  std::thread odometry([&] { EXPECT_FALSE(exchange.Take(5).gravity); });
  exchange.Close();
  odometry.join();
}

}  // namespace
}  // namespace terrace
