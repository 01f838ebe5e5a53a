// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/shape_table.h"

#include <set>

#include <gtest/gtest.h>

#include "core/angles.h"
#include "label_scene.h"

namespace terrace {
namespace {

const RegionShapeLimits kTableLimits{0.52, 1.13, 0.5};

/// A row of squares of 2 m, 3 m apart in x from 0 on, and one floor of 40 m beside them.
PolygonUpdate RowOfSquares() {
  LabelScene scene;
  for (int i = 0; i < 20; ++i) scene.AddLevel(TerrainLabel::kWalkway, {3.0 * i, 0, 0}, 2, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {20, 10, 0}, 40, 2);
  return scene.Update();
}

std::vector<PolygonId> IdsLookedAt(const ShapeTable& table) {
  std::vector<PolygonId> ids;
  for (const RegionShapePtr& shape : table.shapes()) ids.push_back(shape->id());
  return ids;
}

TEST(ShapeTableTest, LooksAtWhatIsNearAndAtWhatChangedWithItsNeighbours) {
  ShapeTable table(kTableLimits, 0.003);
  const PolygonUpdate all = RowOfSquares();
  table.Update(all, TestGravity(), {0, 0, 0.5});
  EXPECT_EQ(table.shapes().size(), 21u);  // all are new
  PolygonUpdate nothing;
  table.Update(nothing, TestGravity(), {0, 0, 0.5});
  EXPECT_EQ(IdsLookedAt(table), (std::vector<PolygonId>{1, 2, 3, 4}));  // the floor begins at y = 9
  // One far away comes anew; what lies within half a metre of it is looked at, too.
  PolygonUpdate one;
  auto grown = std::make_shared<Polygon>(*all.changed[14]);
  for (Eigen::Vector3d& p : grown->outline_world)
    if (p.x() > grown->centroid_world.x()) p.x() += 0.6;
  one.changed = {grown};
  table.Update(one, TestGravity(), {0, 0, 0.5});
  EXPECT_EQ(IdsLookedAt(table), (std::vector<PolygonId>{1, 2, 3, 4, 15, 16}));
  table.Update(nothing, TestGravity(), {20, 2, 0.5});
  EXPECT_EQ(IdsLookedAt(table), (std::vector<PolygonId>{5, 6, 7, 8, 9, 10, 21}));
}

TEST(ShapeTableTest, ForgetsWhatIsRemovedAndLooksAtItsNeighbours) {
  ShapeTable table(kTableLimits, 0.003);
  table.Update(RowOfSquares(), TestGravity(), {0, 0, 0.5});
  PolygonUpdate update;
  update.removed = {21, 99};
  table.Update(update, TestGravity(), {-50, 0, 0.5});
  EXPECT_EQ(table.removed(), std::vector<PolygonId>{21});
  EXPECT_EQ(table.Find(21), nullptr);
  EXPECT_EQ(table.size(), 20u);
  EXPECT_EQ(table.IndexOf(21), -1);
  table.Update({}, TestGravity(), {-50, 0, 0.5});
  EXPECT_TRUE(table.removed().empty());
  EXPECT_TRUE(table.shapes().empty());
}

Gravity TurnedGravity() {
  Gravity turned = TestGravity();
  turned.down_world = Eigen::Vector3d(std::sin(Radians(2.0)), 0, -std::cos(Radians(2.0)));
  return turned;
}

TEST(ShapeTableTest, LooksAnewAtOnceAtWhatIsNearWhenGravityTurns) {
  ShapeTable table(kTableLimits, 0.003);
  table.Update(RowOfSquares(), TestGravity(), {0, 0, 0.5});
  table.Update({}, TurnedGravity(), {0, 0, 0.5});
  for (const PolygonId id : {1, 2, 3, 4}) {
    const int i = table.IndexOf(id);
    ASSERT_GE(i, 0) << id;
    EXPECT_NEAR(table.shapes()[static_cast<std::size_t>(i)]->slope_rad, Radians(2.0), 1e-9) << id;
    EXPECT_TRUE(table.Touched(*table.shapes()[static_cast<std::size_t>(i)], Eigen::Vector3d::Zero())) << id;
  }
}

TEST(ShapeTableTest, LooksAnewAtAllThatIsFarAwayInTheFramesAfterATurnOfGravity) {
  LabelScene scene;
  constexpr int kSquares = 400;
  for (int i = 0; i < kSquares; ++i) scene.AddLevel(TerrainLabel::kWalkway, {5.0 * i, 0, 0}, 2, 2);
  ShapeTable table(kTableLimits, 0.003);
  table.Update(scene.Update(), TestGravity(), {-50, 0, 0.5});
  table.Update({}, TestGravity(), {-50, 0, 0.5});
  EXPECT_TRUE(table.shapes().empty());
  std::set<PolygonId> looked_at;
  int num_frames = 0;
  for (; looked_at.size() < kSquares && num_frames < 100; ++num_frames) {
    table.Update({}, TurnedGravity(), {-50, 0, 0.5});
    EXPECT_LE(table.shapes().size(), 20u);  // a frame costs the same however large the map is
    for (const RegionShapePtr& shape : table.shapes()) {
      EXPECT_NEAR(shape->slope_rad, Radians(2.0), 1e-9) << shape->id();
      EXPECT_TRUE(table.Touched(*shape, Eigen::Vector3d::Zero())) << shape->id();
      looked_at.insert(shape->id());
    }
  }
  EXPECT_EQ(looked_at.size(), static_cast<std::size_t>(kSquares));
  EXPECT_GT(num_frames, 20);
  table.Update({}, TurnedGravity(), {-50, 0, 0.5});
  EXPECT_TRUE(table.shapes().empty()) << "each once";
}

TEST(ShapeTableTest, ShowsTheSameShapesWhenTheRobotComesBackFromFarAway) {
  ShapeTable table(kTableLimits, 0.003);
  table.Update(RowOfSquares(), TestGravity(), {0, 0, 0.5});
  for (int i = 0; i < 20; ++i) table.Update({}, TestGravity(), {500, 0, 0.5});
  EXPECT_TRUE(table.shapes().empty());
  table.Update({}, TestGravity(), {0, 0, 0.5});
  EXPECT_EQ(IdsLookedAt(table), (std::vector<PolygonId>{1, 2, 3, 4}));
  for (const RegionShapePtr& shape : table.shapes()) EXPECT_NEAR(shape->area_m2, 4.0, 1e-9);
}

}  // namespace
}  // namespace terrace
