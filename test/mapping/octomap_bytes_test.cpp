// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/octomap_bytes.h"

#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

namespace terrace {
namespace {

constexpr double kLeaf_m = 0.02;

/// As any program that links OctoMap reads it.
std::unique_ptr<octomap::OcTree> ReadBack(const std::vector<std::uint8_t>& bytes, OctomapFormat format) {
  std::istringstream in(std::string(bytes.begin(), bytes.end()));
  if (format == OctomapFormat::kOt) {
    std::unique_ptr<octomap::AbstractOcTree> tree(octomap::AbstractOcTree::read(in));
    auto* ours = dynamic_cast<octomap::OcTree*>(tree.get());
    if (ours != nullptr) static_cast<void>(tree.release());
    return std::unique_ptr<octomap::OcTree>(ours);
  }
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  if (!tree->readBinary(in)) return nullptr;
  return tree;
}

/// Finest leaves that are occupied, each by its lowest corner.
std::set<std::tuple<int, int, int>> OccupiedIn(octomap::OcTree& tree) {
  tree.expand();
  std::set<std::tuple<int, int, int>> occupied;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const octomap::OcTreeKey key = leaf.getKey();
    if (tree.isNodeOccupied(*leaf))
      occupied.insert({key[0] - kKeyOffset, key[1] - kKeyOffset, key[2] - kKeyOffset});
  }
  return occupied;
}

TEST(OctomapBytesTest, OctomapReadsTheLeavesThatWereWrittenCoarseOnesWithFinerOnesInside) {
  const std::vector<OccupiedLeaf> leaves{
      {{8, -4, 0}, 2, 1}, {{9, -3, 1}, 0, 9}, {{-32768, 32767, -1}, 0, 2}, {{-2, -2, 4}, 1, 3}};
  std::set<std::tuple<int, int, int>> expected;
  for (const OccupiedLeaf& leaf : leaves)
    for (int x = 0; x < 1 << leaf.level; ++x)
      for (int y = 0; y < 1 << leaf.level; ++y)
        for (int z = 0; z < 1 << leaf.level; ++z)
          expected.insert({leaf.corner.x() + x, leaf.corner.y() + y, leaf.corner.z() + z});
  for (const OctomapFormat format : {OctomapFormat::kOt, OctomapFormat::kBt}) {
    const auto tree = ReadBack(OctomapBytes(leaves, kLeaf_m, format), format);
    ASSERT_TRUE(tree);
    EXPECT_DOUBLE_EQ(tree->getResolution(), kLeaf_m);
    EXPECT_EQ(OccupiedIn(*tree), expected);
  }
}

TEST(OctomapBytesTest, ALeafIsAsProbableAsOctomapHasItAfterAsManyHits) {
  const auto tree =
      ReadBack(OctomapBytes({{{1, 2, 3}, 0, 2}}, kLeaf_m, OctomapFormat::kOt), OctomapFormat::kOt);
  octomap::OcTree twice_hit(kLeaf_m);
  const octomap::point3d p(1.5F * kLeaf_m, 2.5F * kLeaf_m, 3.5F * kLeaf_m);
  twice_hit.updateNode(p, true);
  twice_hit.updateNode(p, true);
  ASSERT_TRUE(tree && tree->search(p) != nullptr);
  EXPECT_DOUBLE_EQ(tree->search(p)->getOccupancy(), twice_hit.search(p)->getOccupancy());
}

TEST(OctomapBytesTest, LeavesThatOctomapHasNoKeysForAreLeftOut) {
  const auto tree = ReadBack(OctomapBytes({{{32768, 0, 0}, 0, 1}, {{0, -32769, 0}, 0, 1}, {{5, 5, 5}, 0, 1}},
                                          kLeaf_m, OctomapFormat::kOt),
                             OctomapFormat::kOt);
  ASSERT_TRUE(tree);
  EXPECT_EQ(OccupiedIn(*tree), (std::set<std::tuple<int, int, int>>{{5, 5, 5}}));
}

TEST(OctomapBytesTest, AnEmptyMapIsAFileWithoutLeaves) {
  const auto tree = ReadBack(OctomapBytes({}, kLeaf_m, OctomapFormat::kOt), OctomapFormat::kOt);
  ASSERT_TRUE(tree);
  EXPECT_EQ(tree->size(), 0u);
}

}  // namespace
}  // namespace terrace
