// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/sleeping_ids.h"

#include <vector>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// A level rectangle.
Polygon Rectangle(PolygonId id, double x0, double x1, double y0, double y1, double z = 0.0) {
  Polygon polygon;
  polygon.id = id;
  polygon.revision = 1;
  polygon.plane_world.offset_m = z;
  polygon.centroid_world = {0.5 * (x0 + x1), 0.5 * (y0 + y1), z};
  polygon.area_m2 = (x1 - x0) * (y1 - y0);
  polygon.outline_world = {{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
  polygon.first_seen = Timestamp{1000 * id};
  return polygon;
}

TEST(SleepingIdsTest, WakesWherePartOfItLay) {
  SleepingIds ids;
  ids.Sleep(Rectangle(7, 0.0, 0.2, 0.0, 0.2), 5);
  const auto past = ids.Wake(Rectangle(0, 0.1, 0.3, 0.02, 0.22, 0.02));
  ASSERT_TRUE(past.has_value());
  EXPECT_EQ(past->id, 7);
  EXPECT_EQ(past->num_observations, 5);
  EXPECT_EQ(past->first_seen, Timestamp{7000});
  EXPECT_EQ(ids.size(), 0U);
  EXPECT_EQ(ids.memory_bytes(), 0);
  EXPECT_FALSE(ids.Wake(Rectangle(0, 0.1, 0.3, 0.02, 0.22)).has_value()) << "awake already";
}

TEST(SleepingIdsTest, SleepsOnWhereAnotherPieceLies) {
  SleepingIds ids;
  ids.Sleep(Rectangle(7, 0.0, 0.2, 0.0, 0.2), 5);
  EXPECT_FALSE(ids.Wake(Rectangle(0, 0.0, 0.2, 0.0, 0.2, 0.1)).has_value()) << "a step higher";
  EXPECT_FALSE(ids.Wake(Rectangle(0, 0.21, 0.4, 0.0, 0.2)).has_value()) << "beside it";
  EXPECT_FALSE(ids.Wake(Rectangle(0, 0.17, 0.37, 0.0, 0.2)).has_value()) << "hardly over it";
  Polygon upright = Rectangle(0, 0.0, 0.2, 0.0, 0.2);
  upright.plane_world = {Eigen::Vector3d::UnitX(), 0.1};
  for (Eigen::Vector3d& p : upright.outline_world) p = {0.1, p.y(), p.x() - 0.1};
  EXPECT_FALSE(ids.Wake(upright).has_value()) << "across it";
  EXPECT_EQ(ids.size(), 1U);
}

TEST(SleepingIdsTest, TheOldestWakesOfThoseThatHaveMostInCommonThenOthers) {
  SleepingIds ids;
  ids.Sleep(Rectangle(9, 0.0, 0.2, 0.0, 0.2), 1);
  ids.Sleep(Rectangle(3, 0.0, 0.2, 0.0, 0.2), 1);
  ids.Sleep(Rectangle(5, 0.0, 0.2, 0.0, 0.15), 1);
  ids.Sleep(Rectangle(1, 0.0, 0.2, 0.0, 0.05), 1);
  std::vector<PolygonId> woken;
  for (int i = 0; i < 4; ++i) woken.push_back(ids.Wake(Rectangle(0, 0.0, 0.2, 0.0, 0.2))->id);
  EXPECT_EQ(woken, (std::vector<PolygonId>{3, 5, 9, 1}));
}

TEST(SleepingIdsTest, ForgetsThoseThatHaveSleptLongest) {
  SleepingIds ids;
  for (int i = 0; i <= static_cast<int>(SleepingIds::kMost); ++i)
    ids.Sleep(Rectangle(i + 1, i, i + 0.2, 0.0, 0.2), 1);
  EXPECT_EQ(ids.size(), SleepingIds::kMost);
  EXPECT_FALSE(ids.Wake(Rectangle(0, 0.0, 0.2, 0.0, 0.2)).has_value());
  EXPECT_EQ(ids.Wake(Rectangle(0, 1.0, 1.2, 0.0, 0.2))->id, 2);
}

}  // namespace
}  // namespace terrace
