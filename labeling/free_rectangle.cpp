// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/free_rectangle.h"

#include <algorithm>

namespace terrace {

FreeRectangle LargestFreeRectangle(const std::vector<bool>& free, int rows, int columns) {
  // So many free cells end at the current row in each column.
  std::vector<int> depths(columns, 0);
  FreeRectangle largest;
  int most = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      depths[column] = free[row * columns + column] ? depths[column] + 1 : 0;
    for (int begin = 0; begin < columns; ++begin) {
      int depth = rows;
      for (int end = begin + 1; end <= columns; ++end) {
        depth = std::min(depth, depths[end - 1]);
        if (depth * (end - begin) <= most) continue;
        most = depth * (end - begin);
        largest = {row + 1.0 - depth, row + 1.0, static_cast<double>(begin), static_cast<double>(end)};
      }
    }
  }
  return largest;
}

}  // namespace terrace
