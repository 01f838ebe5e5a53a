// SPDX-License-Identifier: BSD-3-Clause
#include "client/ot_cells.h"

#include <cstdint>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "mapping/octomap_bytes.h"

namespace terrace {
namespace {

using CellKey = std::tuple<int, int, int, int>;

std::vector<std::uint8_t> SomeOctree() {
  return OctomapBytes(
      {{{8, -4, 0}, 2, 1}, {{40, 3, 1}, 0, 9}, {{-32768, 32767, -1}, 0, 2}, {{-2, -2, 4}, 1, 3}}, 0.02,
      OctomapFormat::kOt);
}

TEST(OtCellsTest, ReadsTheLeavesThatOctomapWrites) {
  const OccupiedCells read = ReadOtCells(SomeOctree());
  EXPECT_DOUBLE_EQ(read.leaf_m, 0.02);
  std::set<CellKey> cells;
  for (const OccupiedCell& cell : read.cells)
    cells.insert({cell.corner.x(), cell.corner.y(), cell.corner.z(), cell.num_leaves});
  EXPECT_EQ(cells, (std::set<CellKey>{{8, -4, 0, 4}, {40, 3, 1, 1}, {-32768, 32767, -1, 1}, {-2, -2, 4, 2}}));
  EXPECT_EQ(read.cells.size(), cells.size());
}

TEST(OtCellsTest, ReadsATreeWithoutLeaves) {
  EXPECT_TRUE(ReadOtCells(OctomapBytes({}, 0.02, OctomapFormat::kOt)).cells.empty());
}

TEST(OtCellsTest, RefusesAFileThatWasCutAnywhere) {
  const std::vector<std::uint8_t> whole = SomeOctree();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THROW(ReadOtCells(std::span(whole).first(size)), std::runtime_error) << size;
  }
}

TEST(OtCellsTest, RefusesNodesThatGoDeeperThanAnOctreeOrOnForever) {
  const std::string header = "# Octomap OcTree file\nid OcTree\nsize 9\nres 0.02\ndata\n";
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  for (int i = 0; i < 500000; ++i) bytes.insert(bytes.end(), {0, 0, 0, 0x3f, 1});  // each with a child
  EXPECT_THROW(ReadOtCells(bytes), std::runtime_error);
}

TEST(OtCellsTest, SurvivesBytesThatWereChanged) {
  std::mt19937 random(5);
  const std::vector<std::uint8_t> whole = SomeOctree();
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint8_t> damaged = whole;
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    try {
      const OccupiedCells read = ReadOtCells(damaged);
      EXPECT_LE(read.cells.size(), whole.size());
    } catch (const std::runtime_error&) {
    }
  }
}

}  // namespace
}  // namespace terrace
