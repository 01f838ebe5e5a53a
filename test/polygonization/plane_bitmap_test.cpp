// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_bitmap.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

void SetAll(EvidenceGrid* grid, int value) {
  for (auto& [key, block] : grid->blocks()) block.cells.fill(static_cast<std::int8_t>(value));
}

TEST(PlaneBitmapTest, ShowsEachCellWhereItLies) {
  EvidenceGrid grid;
  grid.Open({-0.2, 0.1}, {0.3, 0.2});
  SetAll(&grid, EvidenceGrid::kOn);
  grid.blocks().at({0, 0}).At(3, 15) = EvidenceGrid::kThrough;
  const PlaneBitmap bitmap = BitmapOf(grid, 5);
  EXPECT_TRUE(bitmap.OnAt({0.005, 0.155}));
  EXPECT_FALSE(bitmap.OnAt({0.035, 0.155}));
  EXPECT_EQ(bitmap.barred(bitmap.PixelAt({0.035, 0.155})), 255);
  EXPECT_FALSE(bitmap.OnAt({0.005, 0.05}));  // takes no evidence
  EXPECT_NEAR((bitmap.CentreOf(0, 0) - bitmap.low).norm(), 0.005 * std::sqrt(2.0), 1e-12);
}

TEST(PlaneBitmapTest, CoarsensRatherThanAllocateWithoutBound) {
  EvidenceGrid grid;
  grid.Open({0.0, 0.0}, {0.5, 0.5});
  grid.Open({60.0, 60.0}, {60.5, 60.5});
  SetAll(&grid, EvidenceGrid::kOn);
  const PlaneBitmap bitmap = BitmapOf(grid, 5);
  EXPECT_LT(bitmap.on.total(), 5e6);
  EXPECT_EQ(bitmap.pixel_m, 0.04);  // 6,064 cells by as many, a sixteenth of them
  EXPECT_TRUE(bitmap.OnAt({0.25, 0.25}));
  EXPECT_TRUE(bitmap.OnAt({60.25, 60.25}));
  EXPECT_FALSE(bitmap.OnAt({30.0, 30.0}));
}

TEST(PlaneBitmapTest, IsEmptyWhereNothingWasSeen) {
  EvidenceGrid grid;
  EXPECT_TRUE(BitmapOf(grid, 5).on.empty());
  grid.Open({0.0, 0.0}, {0.5, 0.5});
  EXPECT_TRUE(BitmapOf(grid, 5).on.empty());
}

}  // namespace
}  // namespace terrace
