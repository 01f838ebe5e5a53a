// SPDX-License-Identifier: BSD-3-Clause
#include "core/plane_rings.h"

#include <vector>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(PlaneRingsTest, ARingHasPositiveAreaWhenItRunsCounterClockwise) {
  EXPECT_DOUBLE_EQ(SignedArea({{1, 1}, {3, 1}, {3, 2}, {1, 2}}), 2.0);
  EXPECT_DOUBLE_EQ(SignedArea({{1, 2}, {3, 2}, {3, 1}, {1, 1}}), -2.0);
}

TEST(PlaneRingsTest, AnLContainsWhatLiesInItsArms) {
  const Ring2 l{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  EXPECT_TRUE(Contains(l, {0.5, 1.5}));
  EXPECT_TRUE(Contains(l, {1.5, 0.5}));
  EXPECT_FALSE(Contains(l, {1.5, 1.5}));
  EXPECT_FALSE(Contains(l, {-0.5, 0.5}));
}

TEST(PlaneRingsTest, TheNearestPointOfASegmentIsAnEndWhereTheFootLiesBeyondIt) {
  const Eigen::Vector2d a(0, 0), b(2, 0);
  EXPECT_EQ(NearestOnSegment(a, b, Eigen::Vector2d(0.5, 3.0)), Eigen::Vector2d(0.5, 0.0));
  EXPECT_EQ(NearestOnSegment(a, b, Eigen::Vector2d(5.0, 1.0)), b);
  EXPECT_EQ(NearestOnSegment(a, b, Eigen::Vector2d(-1.0, 1.0)), a);
  EXPECT_EQ(NearestOnSegment(a, a, Eigen::Vector2d(-1.0, 1.0)), a);
  const Eigen::Vector3d c(0, 0, 0), d(0, 0, 2), p(1, 1, 1);
  EXPECT_EQ(NearestOnSegment(c, d, p), Eigen::Vector3d(0, 0, 1));
}

TEST(PlaneRingsTest, VerticesNearTheLineBetweenOthersAreNotMarked) {
  const Ring2 ring{{0, 0}, {1, 0.01}, {2, 0.5}, {3, 0.01}, {4, 0}, {2, -3}};
  std::vector<bool> marked(ring.size(), false);
  MarkFarVertices(ring, 0, 4, 0.1, &marked);
  // Between the ends and the top the line is 0.25 above the flat vertices.
  EXPECT_EQ(marked, (std::vector<bool>{false, true, true, true, false, false}));
  marked.assign(ring.size(), false);
  MarkFarVertices(ring, 0, 4, 0.3, &marked);
  EXPECT_EQ(marked, (std::vector<bool>{false, false, true, false, false, false}));
  marked.assign(ring.size(), false);
  MarkFarVertices(ring, 4, 6, 0.3, &marked);  // runs past the end of the ring
  EXPECT_EQ(marked, (std::vector<bool>{false, false, false, false, false, true}));
}

TEST(AreSimpleTest, RefusesRingsThatCrossOrTouch) {
  const Ring2 square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Ring2 bow_tie{{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  const Ring2 inside{{0.2, 0.2}, {0.2, 0.4}, {0.4, 0.4}};
  const Ring2 touching{{0.0, 0.5}, {0.2, 0.6}, {0.2, 0.4}};
  EXPECT_TRUE(AreSimple({&square}));
  EXPECT_FALSE(AreSimple({&bow_tie}));
  EXPECT_TRUE(AreSimple({&square, &inside}));
  EXPECT_FALSE(AreSimple({&square, &touching}));
}

}  // namespace
}  // namespace terrace
