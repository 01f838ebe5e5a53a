// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_rings.h"

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
