// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/free_rectangle.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// Cells of the largest free rectangle, by trying all.
int MostFreeCells(const std::vector<bool>& free, int rows, int columns) {
  int most = 0;
  for (int r0 = 0; r0 < rows; ++r0)
    for (int r1 = r0 + 1; r1 <= rows; ++r1)
      for (int c0 = 0; c0 < columns; ++c0)
        for (int c1 = c0 + 1; c1 <= columns; ++c1) {
          bool all = true;
          for (int r = r0; r < r1; ++r)
            for (int c = c0; c < c1; ++c) all &= free[r * columns + c];
          if (all) most = std::max(most, (r1 - r0) * (c1 - c0));
        }
  return most;
}

TEST(FreeRectangleTest, IsFreeAndAsLargeAsTheBestOfAllRectangles) {
  std::mt19937 generator(7);
  for (int trial = 0; trial < 200; ++trial) {
    const int rows = 1 + static_cast<int>(generator() % 7), columns = 1 + static_cast<int>(generator() % 8);
    std::vector<bool> free;
    for (int i = 0; i < rows * columns; ++i) free.push_back(generator() % 4 != 0);
    const FreeRectangle found = LargestFreeRectangle(free, rows, columns);
    const int cells =
        static_cast<int>((found.row_end - found.row_begin) * (found.column_end - found.column_begin));
    EXPECT_EQ(cells, MostFreeCells(free, rows, columns));
    for (int r = static_cast<int>(found.row_begin); r < found.row_end; ++r)
      for (int c = static_cast<int>(found.column_begin); c < found.column_end; ++c)
        EXPECT_TRUE(free[r * columns + c]);
  }
}

TEST(FreeRectangleTest, IsEmptyWhereNothingIsFree) {
  const FreeRectangle found = LargestFreeRectangle(std::vector<bool>(6, false), 2, 3);
  EXPECT_EQ(found.row_end - found.row_begin, 0.0);
}

}  // namespace
}  // namespace terrace
