// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/evidence_grid.h"

#include <cmath>

#include <gtest/gtest.h>

namespace terrace {
namespace {

void SetOn(EvidenceGrid* grid, double x0, double x1, double y0, double y1) {
  for (auto& [key, block] : grid->blocks()) {
    block.num_looks = 1;
    for (int y = 0; y < EvidenceGrid::kBlockCells; ++y) {
      for (int x = 0; x < EvidenceGrid::kBlockCells; ++x) {
        const double px = grid->cell_m() * (key.first * EvidenceGrid::kBlockCells + x + 0.5);
        const double py = grid->cell_m() * (key.second * EvidenceGrid::kBlockCells + y + 0.5);
        if (px > x0 && px < x1 && py > y0 && py < y1) block.At(x, y) = 20;
      }
    }
  }
}

TEST(EvidenceGridTest, CellsOnEitherSideOfTheOriginAreTheirOwn) {
  EvidenceGrid grid;
  grid.Open({-0.3, -0.3}, {0.3, 0.3});
  SetOn(&grid, -0.02, 0.0, -0.02, 0.0);
  EXPECT_EQ(grid.At({-0.005, -0.005}), 20);
  EXPECT_EQ(grid.At({-0.015, -0.015}), 20);
  EXPECT_EQ(grid.At({0.005, -0.005}), 0);
  EXPECT_EQ(grid.At({-0.025, -0.005}), 0);
  EXPECT_EQ(grid.At({5.0, 5.0}), 0);
}

TEST(EvidenceGridTest, AdoptsWhatATurnedGridKnows) {
  EvidenceGrid turned;
  turned.Open({-0.5, -0.5}, {0.5, 0.5});
  SetOn(&turned, -0.2, 0.2, -0.1, 0.1);
  const double angle = 0.4;
  const Eigen::Rotation2Dd rotation(angle);
  EvidenceGrid grid;
  grid.Adopt(turned, Eigen::Affine2d(rotation.inverse()));
  for (double x = -0.3; x < 0.3; x += 0.013) {
    for (double y = -0.3; y < 0.3; y += 0.013) {
      const Eigen::Vector2d p = rotation * Eigen::Vector2d(x, y);
      const double inside = std::min(0.2 - std::abs(x), 0.1 - std::abs(y));
      if (inside > 0.01) {
        EXPECT_EQ(grid.At(p), 20) << x << ' ' << y;
      } else if (inside < -0.01) {
        EXPECT_EQ(grid.At(p), 0) << x << ' ' << y;
      }
    }
  }
}

TEST(EvidenceGridTest, TakesEvidenceOnlyWhereItIsOpen) {
  EvidenceGrid grid;
  grid.Open({-0.05, -0.05}, {0.05, 0.05});
  const auto is_open = [&](double x, double y) {
    const auto [key, cell] = grid.Locate({x, y});
    return grid.blocks().at(key).IsOpen(cell.x(), cell.y());
  };
  EXPECT_TRUE(is_open(0.0, 0.0));
  EXPECT_TRUE(is_open(-0.05, 0.05));
  EXPECT_FALSE(is_open(0.1, 0.0));  // groups are 4 cm wide
  SetOn(&grid, -0.05, 0.05, -0.05, 0.05);
  grid.Close();
  EXPECT_FALSE(is_open(0.0, 0.0));
  EXPECT_EQ(grid.At({0.0, 0.0}), 20);  // what is known stays
}

}  // namespace
}  // namespace terrace
