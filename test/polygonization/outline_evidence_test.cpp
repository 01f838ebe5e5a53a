// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline_evidence.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(OutlineEvidenceTest, SeesExactlyTheCellsWhoseMiddleLiesInARing) {
  // A ring of many edges on a circle, about the origin of the grid.
  TracedPiece piece;
  constexpr double kRadius_m = 0.253;
  for (int i = 0; i < 200; ++i)
    piece.outline.push_back(
        {kRadius_m * std::cos(i * std::numbers::pi / 100), kRadius_m * std::sin(i * std::numbers::pi / 100)});
  EvidenceGrid evidence(0.01);
  TakeForSeen(piece, 9, &evidence);
  for (int y = -30; y < 30; ++y) {
    for (int x = -30; x < 30; ++x) {
      const Eigen::Vector2d middle(0.01 * (x + 0.5), 0.01 * (y + 0.5));
      if (std::abs(middle.norm() - kRadius_m) < 1e-3) continue;  // between circle and ring
      EXPECT_EQ(evidence.At(middle), middle.norm() < kRadius_m ? 9 : 0) << middle.transpose();
    }
  }
}

}  // namespace
}  // namespace terrace
