// SPDX-License-Identifier: BSD-3-Clause
#include "core/bounded_queue.h"

#include <numeric>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(BoundedQueueTest, DropsTheOldestItemWhenFull) {
  BoundedQueue<int> queue(2, WhenFull::kDropOldest);
  for (int i = 1; i <= 4; ++i) EXPECT_TRUE(queue.Push(i));
  EXPECT_EQ(queue.num_dropped(), 2);
  EXPECT_EQ(queue.Pop(), 3);
  EXPECT_EQ(queue.Pop(), 4);
}

TEST(BoundedQueueTest, HandsADroppedItemToTheOneThatIsTakenInItsPlace) {
  for (const std::size_t capacity : {1u, 2u}) {
    BoundedQueue<int> queue(capacity, WhenFull::kDropOldest,
                            [](int dropped, int* next) { *next += dropped; });
    for (const int i : {1, 10, 100}) queue.Push(i);
    queue.Close();
    int sum = 0;
    while (const auto item = queue.Pop()) sum += *item;
    EXPECT_EQ(sum, 111) << "capacity " << capacity;
  }
}

TEST(BoundedQueueTest, LosesNothingWhenTheProducerWaits) {
  BoundedQueue<int> queue(1, WhenFull::kWait);
  std::thread producer([&] {
    for (int i = 0; i < 1000; ++i) queue.Push(i);
    queue.Close();
  });
  std::vector<int> taken;
  while (const auto item = queue.Pop()) taken.push_back(*item);
  producer.join();
  std::vector<int> expected(1000);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(taken, expected);
  EXPECT_EQ(queue.num_dropped(), 0);
}

TEST(BoundedQueueTest, GivesWhatIsInsideAfterClosingAndThenNothing) {
  BoundedQueue<int> queue(3, WhenFull::kWait);
  queue.Push(7);
  queue.Close();
  EXPECT_FALSE(queue.Push(8));
  EXPECT_EQ(queue.Pop(), 7);
  EXPECT_EQ(queue.Pop(), std::nullopt);
}

TEST(BoundedQueueTest, ClosingWakesAProducerThatWaits) {
  BoundedQueue<int> queue(1, WhenFull::kWait);
  queue.Push(1);
  bool accepted = true;
  std::thread producer([&] { accepted = queue.Push(2); });
  queue.Close();
  producer.join();
  EXPECT_FALSE(accepted);
}

}  // namespace
}  // namespace terrace
