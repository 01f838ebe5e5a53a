// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/body_height_check.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

using testing::HasSubstr;

std::vector<RegionShapePtr> Floor() {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {3, 0, 0}, 5, 2);
  return {MakeRegionShape(scene.Update().changed[0], Eigen::Matrix3d::Identity(), {0.52, 1.13, 0.5})};
}

/// All that is said while the robot walks 2 m over the floor, body at heights(x).
template <typename Heights>
std::vector<std::string> Walk(BodyHeightCheck& check, bool at_feet, double speed, Heights heights) {
  std::vector<std::string> said;
  for (int i = 0; i < 80; ++i) {
    const double x = speed * i;
    if (auto warning = check.Look(Floor(), {x, 0.0, heights(x)}, at_feet)) said.push_back(*warning);
  }
  return said;
}

TEST(BodyHeightCheckTest, NamesTheKeyAndBothHeightsOnceWhenTheyDisagree) {
  BodyHeightCheck check(0.36);
  const auto said = Walk(check, true, 0.03, [](double) { return 0.25; });
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], HasSubstr("robot.body_height_m is 0.36"));
  EXPECT_THAT(said[0], HasSubstr("0.25 m below"));
}

TEST(BodyHeightCheckTest, IsSilentWhenTheyAgreeAndTheBodyBounces) {
  BodyHeightCheck check(0.36);
  EXPECT_TRUE(Walk(check, true, 0.03, [](double x) { return 0.36 + 0.03 * std::sin(20.0 * x); }).empty());
}

TEST(BodyHeightCheckTest, IsSilentOnStairsWhereTheNearestGroundIsAnother) {
  BodyHeightCheck climbing(0.36);
  EXPECT_TRUE(Walk(climbing, true, 0.03, [](double x) { return 0.5 + 0.6 * x; }).empty());
  BodyHeightCheck standing(0.36);
  EXPECT_TRUE(Walk(standing, true, 0.0, [](double) { return 0.7; }).empty());
}

TEST(BodyHeightCheckTest, SpeaksWhileItStandsWhenNoGroundAtAllIsWhereTheSettingsSay) {
  BodyHeightCheck check(0.36);
  const auto said = Walk(check, false, 0.0, [](double) { return 1.2; });
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], HasSubstr("labels are unsure"));
}

TEST(BodyHeightCheckTest, TrustsNoLabelMoreThanHalfWhileNoGroundIsSeenAtTheFeet) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {3, 0, 0}, 5, 2);
  TerrainLabeler labeler = MakeLabeler();
  for (const auto& region : LabelOften(labeler, scene.Update(), StandingAt(0, 0, 0.9))->regions)
    EXPECT_LE(region->confidence, 0.5);
  LabelOften(labeler, scene.Update(), StandingAt(0, 0, 0.9), 40);
  TerrainLabeler standing = MakeLabeler();
  for (const auto& region : LabelOften(standing, scene.Update(), StandingAt(0, 0))->regions)
    EXPECT_GT(region->confidence, 0.5);
}

}  // namespace
}  // namespace terrace
