// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/stance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

using testing::ElementsAre;

constexpr StanceLimits kStanceLimits{0.36, 2.0, 0.15};
const Eigen::Matrix3d kLevel = Eigen::Matrix3d::Identity();

std::vector<RegionShapePtr> StanceShapes(const LabelScene& scene) {
  std::vector<RegionShapePtr> shapes;
  for (const PolygonPtr& polygon : scene.Update().changed)
    shapes.push_back(MakeRegionShape(polygon, kLevel, {0.52, 1.13, 0.5}));
  return shapes;
}

TEST(StanceMemoryTest, StandsOnTheNearestGroundAtTheHeightOfItsFeet) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kObstacle, {0.5, 0, 0.5}, 0.4, 0.4);  // nearer, but a table's top
  scene.AddLevel(TerrainLabel::kWalkway, {2.5, 0, 0}, 3, 2);
  scene.AddLevel(TerrainLabel::kLevel, {0.5, 3, -0.6}, 3, 3);  // lower
  StanceMemory stances(kStanceLimits);
  stances.Stand({0, 0, 0.36}, kLevel);
  EXPECT_THAT(stances.Seeds(StanceShapes(scene), kLevel), ElementsAre(1));
  EXPECT_TRUE(stances.at_feet());
}

TEST(StanceMemoryTest, RemembersWhereItStood) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {0, 0, 0}, 2, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {6, 0, 0}, 2, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {12, 0, 0}, 2, 2);
  StanceMemory stances(kStanceLimits);
  const auto shapes = StanceShapes(scene);
  for (double x = 0.0; x <= 6.0; x += 0.1) {
    stances.Stand({x, 0, 0.36}, kLevel);
    stances.Seeds(shapes, kLevel);
  }
  EXPECT_THAT(stances.Seeds(shapes, kLevel), ElementsAre(0, 1));
}

TEST(StanceMemoryTest, SaysThatItGuessesWhenNoGroundIsAtItsFeet) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kLevel, {2, 0, -1}, 1, 1);
  scene.AddLevel(TerrainLabel::kLevel, {3, 0, -1.2}, 3, 3);
  StanceMemory stances(kStanceLimits);
  stances.Stand({0, 0, 0.36}, kLevel);
  EXPECT_THAT(stances.Seeds(StanceShapes(scene), kLevel), ElementsAre(1));
  EXPECT_FALSE(stances.at_feet());
  EXPECT_TRUE(stances.disagrees());
}

TEST(StanceMemoryTest, DoesNotDisagreeWhereHardlyAnyGroundIsSeen) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kStairTread, {1, 0, -0.3}, 0.28, 1.0);
  StanceMemory stances(kStanceLimits);
  stances.Stand({0, 0, 0.36}, kLevel);
  stances.Seeds(StanceShapes(scene), kLevel);
  EXPECT_FALSE(stances.at_feet());
  EXPECT_FALSE(stances.disagrees());
}

}  // namespace
}  // namespace terrace
