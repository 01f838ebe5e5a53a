// SPDX-License-Identifier: BSD-3-Clause
#include "core/stage.h"

#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(StageTest, WorksInOrderAndEndsTheChainWhenTheFirstQueueCloses) {
  BoundedQueue<int> numbers(2, WhenFull::kWait);
  BoundedQueue<int> squares(2, WhenFull::kWait);
  std::vector<int> seen;
  Stage<int> square(
      &numbers, [&](int n) { return squares.Push(n * n); }, [&] { squares.Close(); });
  Stage<int> collect(
      &squares,
      [&](int n) {
        seen.push_back(n);
        return true;
      },
      [] {});
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(numbers.Push(i));
  numbers.Close();
  square.Join();
  collect.Join();
  ASSERT_EQ(seen.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], i * i);
}

TEST(StageTest, AStepThatThrowsClosesItsInputAndTheErrorReachesTheOneWhoJoins) {
  BoundedQueue<int> numbers(1, WhenFull::kWait);
  Stage<int> fails(
      &numbers, [](int) -> bool { throw std::runtime_error("no"); }, [] {});
  // The producer is never left waiting: sooner or later the closed queue refuses its items.
  while (numbers.Push(1)) {
  }
  EXPECT_THROW(fails.Join(), std::runtime_error);
}

TEST(StageTest, ADestructorEndsAStageThatStillWaits) {
  BoundedQueue<int> numbers(1, WhenFull::kWait);
  bool ended = false;
  {
    Stage<int> waits(
        &numbers, [](int) { return true; }, [&] { ended = true; });
  }
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace terrace
