// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/frame_leaves.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

constexpr int kImageWidth = 64;

TEST(LeafAddressTest, HoldsLevelAndCorner) {
  const LeafAddress address(1, 65535, 40000, 3);
  EXPECT_EQ(address.x(), 1);
  EXPECT_EQ(address.y(), 65535);
  EXPECT_EQ(address.z(), 40000);
  EXPECT_EQ(address.level(), 3);
  EXPECT_NE(address, LeafAddress(1, 65535, 40000, 2));
}

TEST(FrameLeavesTest, SumsThePointsOfALeafWhereverTheyLieInTheImage) {
  FrameLeaves leaves;
  leaves.Clear(kImageWidth);
  const LeafAddress wall(10, 20, 30, 0), floor(10, 20, 29, 0);
  for (int u = 0; u < kImageWidth; ++u) leaves.At(u % 3 == 0 ? wall : floor, u).moments.Add(2.0F, {0, 0, 1});
  ASSERT_EQ(leaves.leaves().size(), 2U);
  EXPECT_EQ(leaves.leaves()[0].address, wall);
  EXPECT_EQ(leaves.leaves()[0].moments.num_points, 22);
  EXPECT_EQ(leaves.leaves()[1].moments.num_points, 42);
  leaves.Clear(kImageWidth);
  EXPECT_TRUE(leaves.leaves().empty());
  EXPECT_EQ(leaves.At(wall, 0).moments.num_points, 0);
}

TEST(FrameLeavesTest, TellsTheNextFrameWhereALeafIsKept) {
  FrameLeaves leaves;
  leaves.Clear(kImageWidth);
  const LeafAddress address(10, 20, 30, 1);
  EXPECT_EQ(leaves.At(address, 5).place.leaf, kNothing);
  leaves.Remember(address, {17, 4});
  leaves.Clear(kImageWidth);
  const FrameLeaf& again = leaves.At(address, 5);
  EXPECT_EQ(again.place.leaf, 17);
  EXPECT_EQ(again.place.cell, 4);
  EXPECT_EQ(leaves.At(LeafAddress(10, 20, 31, 1), 5).place.leaf, kNothing);
}

TEST(FrameLeavesTest, GrowsWithTheFrameAndForgetsNoPoint) {
  FrameLeaves leaves;
  leaves.Clear(kImageWidth);
  constexpr int kMany = 50;
  for (int round = 0; round < 2; ++round)
    for (std::uint16_t x = 0; x < kMany; ++x)
      for (std::uint16_t y = 0; y < kMany; ++y)
        for (std::uint16_t z = 0; z < kMany; ++z)
          leaves.At(LeafAddress(x, y, z, 0), x).moments.Add(1.0F, Eigen::Vector3f::Zero());
  ASSERT_EQ(leaves.leaves().size(), static_cast<std::size_t>(kMany * kMany * kMany));
  for (const FrameLeaf& leaf : leaves.leaves()) ASSERT_EQ(leaf.moments.num_points, 2);
}

}  // namespace
}  // namespace terrace
