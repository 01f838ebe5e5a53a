// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/ring_simplifier.h"

#include <cmath>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// Stairs of pixels along a slanted line from (0, 0), closed far below.
Ring2 PixelledRamp(double slope, double pixel_m, int num) {
  Ring2 ring{{0.0, -0.5}, {num * pixel_m, -0.5}};
  for (int i = num; i > 0; --i) {
    const double y = pixel_m * std::round(slope * (i - 0.5));
    if (i == num || y != ring.back().y()) ring.emplace_back(i * pixel_m, y);
    ring.emplace_back((i - 1) * pixel_m, y);
  }
  return ring;
}

TEST(RingSimplifierTest, AnEdgeAlongPixelsBecomesTheLineThroughThem) {
  for (const double slope : {0.1, 0.23}) {
    const Ring2 traced = PixelledRamp(slope, 0.01, 100);
    const std::vector<Ring2> rings = SimplifyRings({traced}, {0.0105, 2000, 0.012});
    ASSERT_EQ(rings.size(), 1U);
    ASSERT_EQ(rings[0].size(), 4U) << "slope " << slope;
    for (const Eigen::Vector2d& p : rings[0]) {
      if (p.y() < -0.4) continue;  // the far side
      EXPECT_NEAR(p.y(), slope * p.x(), 0.003) << "slope " << slope;
    }
  }
}

TEST(RingSimplifierTest, AnEdgeAlongAGivenLineLiesOnIt) {
  const Ring2 traced = PixelledRamp(0.1, 0.01, 100);
  // Less than half a pixel off what was traced.
  const Eigen::Vector2d along = Eigen::Vector2d(1.0, 0.1).normalized();
  const EdgeLine line{{0.0, 0.004}, along, {along.y(), -along.x()}, -0.1, 2.0};
  const std::vector<Ring2> rings = SimplifyRings({traced}, {0.0105, 2000, 0.012}, {line});
  ASSERT_EQ(rings[0].size(), 4U);
  for (const Eigen::Vector2d& p : rings[0])
    EXPECT_TRUE(p.y() < -0.4 || std::abs(p.y() - 0.004 - 0.1 * p.x()) < 1e-9) << p.transpose();
  const EdgeLine elsewhere{{0.0, 0.004}, along, {along.y(), -along.x()}, 3.0, 4.0};
  const std::vector<Ring2> fitted = SimplifyRings({traced}, {0.0105, 2000, 0.012}, {elsewhere});
  for (const Eigen::Vector2d& p : fitted[0])
    EXPECT_TRUE(p.y() < -0.4 || std::abs(p.y() - 0.1 * p.x()) < 0.003) << p.transpose();
}

TEST(RingSimplifierTest, RingsThatLieCloseDoNotTouchWhenSimplified) {
  // A hole two pixels from an outer edge that steps.
  Ring2 outline{{0, 0}, {1, 0}, {1, 1}};
  for (int i = 9; i >= 0; --i) {
    const double y = i % 2 == 0 ? 1.0 : 0.99;
    outline.emplace_back(0.1 * (i + 1), y);
    outline.emplace_back(0.1 * i, y);
  }
  const Ring2 hole{{0.1, 0.5}, {0.1, 0.97}, {0.9, 0.97}, {0.9, 0.5}};
  const std::vector<Ring2> rings = SimplifyRings({outline, hole}, {0.05, 2000, 0.012});
  ASSERT_EQ(rings.size(), 2U);
  EXPECT_TRUE(AreSimple({&rings[0], &rings[1]}));
  EXPECT_GT(SignedArea(rings[0]), 0.0);
  EXPECT_LT(SignedArea(rings[1]), 0.0);
}

TEST(RingSimplifierTest, HasAtMostAsManyVerticesAsAreAllowed) {
  Ring2 ring;
  for (int i = 0; i < 400; ++i) {
    const double angle = 0.015707963 * i, radius = 1.0 + 0.05 * std::sin(37.0 * angle);
    ring.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  EXPECT_GT(SimplifyRings({ring}, {0.001, 5000, 0.0})[0].size(), 100U);
  EXPECT_LE(SimplifyRings({ring}, {0.001, 40, 0.0})[0].size(), 40U);
}

TEST(RingSimplifierTest, AHoleThatTheOutlineLeavesBesideItIsNone) {
  // A strip of 4 cm at one side is drawn back to a line of intersection, and the hole lies in it.
  const Ring2 outline{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Ring2 hole{{0.985, 0.5}, {0.985, 0.52}, {0.995, 0.52}, {0.995, 0.5}};
  const Ring2 inner{{0.4, 0.4}, {0.4, 0.6}, {0.6, 0.6}, {0.6, 0.4}};
  const EdgeLine line{{0.97, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, 0.0, 1.0};
  const std::vector<Ring2> rings = SimplifyRings({outline, hole, inner}, {0.05, 100, 0.04}, {line});
  ASSERT_EQ(rings.size(), 2U);
  EXPECT_TRUE(Contains(rings[0], rings[1][0]));
}

TEST(RingSimplifierTest, TheFarSideOfAThinStripStaysOffItsLine) {
  // The line bounds the strip from below; its upper side lies within reach, too.
  const Ring2 strip{{0, 0}, {1, 0}, {1, 0.012}, {0, 0.012}};
  const EdgeLine line{{0.0, 0.002}, {1.0, 0.0}, {0.0, 1.0}, 0.0, 1.0};
  const std::vector<Ring2> rings = SimplifyRings({strip}, {0.002, 100, 0.012}, {line});
  ASSERT_EQ(rings.size(), 1U);
  EXPECT_GT(SignedArea(rings[0]), 0.008);
}

}  // namespace
}  // namespace terrace
