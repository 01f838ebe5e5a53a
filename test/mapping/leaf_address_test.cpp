// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/leaf_address.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(LeafAddressTest, KeysMeanTheIndexNearestToWhereOneIs) {
  for (const int near : {0, -40'000, 65'536, 1'000'000'000}) {
    for (const int away : {0, 1, -1, 5'000, -kMaxReachLeaves, kMaxReachLeaves})
      EXPECT_EQ(IndexOf(KeyOf(near + away), near), near + away) << "near " << near << ", away " << away;
  }
}

TEST(LeafAddressTest, PlacesShareAKeyOnlyWhereTheOctreeNeverHoldsBoth) {
  EXPECT_EQ(KeyOf(7), KeyOf(7 + 65'536));
  EXPECT_GT(65'536, 2 * kMaxReachLeaves);
  for (int apart = 1; apart <= 2 * kMaxReachLeaves; apart += 97) EXPECT_NE(KeyOf(-3), KeyOf(-3 + apart));
}

TEST(LeafAddressTest, HoldsItsCornerAndItsLevel) {
  const LeafIndex corner(-70'001, 12, 655'360);
  const LeafAddress address(corner, 3);
  EXPECT_EQ(address.level(), 3);
  EXPECT_EQ(address.Corner(corner + LeafIndex(900, -900, 16'000)), corner);
  EXPECT_EQ(address, LeafAddress(corner, 3));
  EXPECT_FALSE(address == LeafAddress(corner, 2));
  EXPECT_FALSE(address == LeafAddress(corner + LeafIndex(0, 1, 0), 3));
}

TEST(LeafAddressTest, LeavesAtLeastFourOfTheCoarsestAlongACell) {
  for (const int leaves : {4, 8, 16, 32, 64}) EXPECT_EQ(leaves >> CoarsestLevel(leaves), 4);
}

}  // namespace
}  // namespace terrace
