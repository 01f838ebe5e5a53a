// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_bitmap.h"

#include <algorithm>
#include <limits>

namespace terrace {
namespace {

constexpr double kMostPixels = 4e6;
constexpr int kBlockEdge = EvidenceGrid::kBlockCells;

bool IsOn(std::int8_t cell) { return cell >= EvidenceGrid::kOn; }

}  // namespace

PlaneBitmap BitmapOf(const EvidenceGrid& grid, int margin_px) {
  int low_x = std::numeric_limits<int>::max(), low_y = low_x;
  int high_x = std::numeric_limits<int>::min(), high_y = high_x;
  for (const auto& [key, block] : grid.blocks()) {
    if (std::none_of(block.cells.begin(), block.cells.end(), IsOn)) continue;
    low_x = std::min(low_x, key.first);
    high_x = std::max(high_x, key.first + 1);
    low_y = std::min(low_y, key.second);
    high_y = std::max(high_y, key.second + 1);
  }
  PlaneBitmap bitmap;
  bitmap.pixel_m = grid.cell_m();
  if (low_x > high_x) return bitmap;
  int cells_per_px = 1;
  const double width = 1.0 * (high_x - low_x) * kBlockEdge, height = 1.0 * (high_y - low_y) * kBlockEdge;
  while (width * height > kMostPixels * cells_per_px * cells_per_px && cells_per_px < kBlockEdge)
    cells_per_px *= 2;
  bitmap.pixel_m *= cells_per_px;
  const int block_px = kBlockEdge / cells_per_px;
  bitmap.low =
      grid.block_m() * Eigen::Vector2d(low_x, low_y) - Eigen::Vector2d::Constant(margin_px * bitmap.pixel_m);
  const cv::Size size((high_x - low_x) * block_px + 2 * margin_px,
                      (high_y - low_y) * block_px + 2 * margin_px);
  bitmap.on = cv::Mat1b::zeros(size);
  bitmap.barred = cv::Mat1b::zeros(size);
  for (const auto& [key, block] : grid.blocks()) {
    const int x0 = margin_px + (key.first - low_x) * block_px,
              y0 = margin_px + (key.second - low_y) * block_px;
    for (int y = 0; y < kBlockEdge; ++y) {
      const int row = y0 + y / cells_per_px;
      if (row < 0 || row >= size.height) continue;
      for (int x = 0; x < kBlockEdge; ++x) {
        const int column = x0 + x / cells_per_px;
        const int cell = block.At(x, y);
        if (column < 0 || column >= size.width) continue;
        if (cell <= EvidenceGrid::kThrough)
          bitmap.barred(row, column) = 255;
        else if (cell >= EvidenceGrid::kOn && block.IsOpen(x, y))
          bitmap.on(row, column) = 255;
      }
    }
  }
  bitmap.on.setTo(0, bitmap.barred);
  return bitmap;
}

}  // namespace terrace
