// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace terrace {

/// A rectangle of a raster, from the first cell's begin to the last one's end.
struct FreeRectangle {
  double row_begin = 0.0;
  double row_end = 0.0;
  double column_begin = 0.0;
  double column_end = 0.0;
};

/// The rectangle of most cells that are all free; of equals the one that ends first. Nothing free: an empty
/// one.
/// @param free  rows after each other
FreeRectangle LargestFreeRectangle(const std::vector<bool>& free, int rows, int columns);

}  // namespace terrace
