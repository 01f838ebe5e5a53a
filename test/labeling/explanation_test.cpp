// SPDX-License-Identifier: BSD-3-Clause
#include "core/explanation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A corridor with a flight of six steps of 0.17 m and 0.28 m, the landing, and a box 0.4 m high: ids 1 to 3
/// are floor and walls.
LabelScene CorridorWithStairsAndBox() {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {3, 0, 0}, 8, 2);
  scene.AddFace(TerrainLabel::kWall, {-1, 1, 0}, {7, 1, 0}, 2.6);
  scene.AddFace(TerrainLabel::kWall, {7, -1, 0}, {-1, -1, 0}, 2.6);
  KnownFlight flight;
  flight.foot = {7, 0, 0};
  scene.AddFlight(flight);
  scene.AddLevel(TerrainLabel::kWalkway, {9.9, 0, 1.02}, 3, 2);
  scene.AddBox({4, 0.5, 0}, 0.6, 0.36, 0.4, 0.04);
  return scene;
}

/// The explanation of one region, which is there.
RegionExplanation Explained(const TerrainLabeler& labeler, std::int64_t id) {
  const Explanations explanations = labeler.Explain(id);
  EXPECT_EQ(explanations.regions.size(), 1u) << id;
  return explanations.regions.empty() ? RegionExplanation{} : explanations.regions.front();
}

TEST(ExplanationTest, ExplainsEveryRegionAndStaircaseAsItWasTold) {
  const LabelScene scene = CorridorWithStairsAndBox();
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update(), StandingAt(5, 0));
  const Explanations all = labeler.Explain();
  ASSERT_EQ(all.regions.size(), map->regions.size());
  for (std::size_t i = 0; i < all.regions.size(); ++i) {
    const RegionExplanation& e = all.regions[i];
    const TerrainRegion& told = *map->regions[i];
    EXPECT_EQ(e.id, told.id);
    EXPECT_EQ(e.label, told.label);
    EXPECT_EQ(e.staircase, told.staircase_id);
    EXPECT_EQ(e.step_index, told.step_index);
    EXPECT_EQ(e.rule == LabelRule::kInferredStep, told.predicted());
    EXPECT_THAT(e.text, HasSubstr(Name(told.label)));
  }
  ASSERT_EQ(all.staircases.size(), map->staircases.size());
  EXPECT_EQ(all.staircases[0].id, map->staircases[0].id);
}

TEST(ExplanationTest, TellsTheNumbersThatALabelWasDecidedBy) {
  const LabelScene scene = CorridorWithStairsAndBox();
  TerrainLabeler labeler = MakeLabeler();
  LabelOften(labeler, scene.Update(), StandingAt(5, 0));

  const RegionExplanation floor = Explained(labeler, 1);
  EXPECT_EQ(floor.rule, LabelRule::kReachableGround);
  EXPECT_NEAR(floor.slope_rad, 0.0, 1e-6);
  EXPECT_EQ(floor.large, true);
  EXPECT_EQ(floor.reachable, true);
  EXPECT_THAT(floor.text, HasSubstr("It would be a ramp from a slope of 8.0 deg on"));

  const RegionExplanation wall = Explained(labeler, 2);
  EXPECT_EQ(wall.rule, LabelRule::kHighFace);
  ASSERT_TRUE(wall.height_m.has_value());
  EXPECT_NEAR(*wall.height_m, 2.6, 1e-3);
  EXPECT_NEAR(wall.slope_rad, 0.5 * std::numbers::pi, 1e-6);

  const auto top = std::find_if(scene.pieces.rbegin(), scene.pieces.rend(), [](const KnownPiece& piece) {
    return piece.outline[0].z() == piece.outline[2].z();
  });
  const RegionExplanation box_top = Explained(labeler, scene.pieces.rend() - top);
  EXPECT_EQ(box_top.rule, LabelRule::kStandsOnGround);
  ASSERT_TRUE(box_top.height_m.has_value());
  EXPECT_NEAR(*box_top.height_m, 0.4, 1e-3);
  EXPECT_EQ(box_top.reachable, false);
}

TEST(ExplanationTest, TellsWhereTheGroundGoesOnAndHowHighTheStepIs) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {5, 0, 0}, 4, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {9, 0, 0.15}, 4, 2);
  TerrainLabeler labeler = MakeLabeler();
  LabelOften(labeler, scene.Update(), StandingAt(1, 0));
  const RegionExplanation middle = Explained(labeler, 2);
  ASSERT_EQ(middle.neighbors.size(), 2u);
  EXPECT_EQ(middle.neighbors[0].id, 1);
  EXPECT_TRUE(middle.neighbors[0].joins);
  EXPECT_EQ(middle.neighbors[1].id, 3);
  EXPECT_FALSE(middle.neighbors[1].joins);
  EXPECT_NEAR(middle.neighbors[1].step_m, 0.15, 1e-6);
}

TEST(ExplanationTest, TellsWhichStepsOfAStaircaseWereSeenAndWhatTheyWouldBeWithoutIt) {
  LabelScene scene = CorridorWithStairsAndBox();
  TerrainLabeler labeler = MakeLabeler();
  LabelOften(labeler, scene.Update(), StandingAt(5, 0));
  const Explanations all = labeler.Explain();
  ASSERT_EQ(all.staircases.size(), 1u);
  const StaircaseExplanation& stairs = all.staircases[0];
  EXPECT_EQ(stairs.num_risers, 6);
  EXPECT_THAT(stairs.risers_seen, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(stairs.treads_seen, ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(stairs.foot_region, 1);
  EXPECT_EQ(stairs.num_seen, 11);
  EXPECT_THAT(stairs.text, HasSubstr("risers 1 to 6 and treads 1 to 5"));
  for (const RegionExplanation& e : all.regions) {
    if (e.rule != LabelRule::kStep) continue;
    ASSERT_TRUE(e.by_itself.has_value());
    EXPECT_NE(*e.by_itself, e.label);
  }
}

TEST(ExplanationTest, TellsOfALabelThatIsAboutToChange) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {5, 0, 0}, 4, 2);
  TerrainLabeler labeler = MakeLabeler();
  LabelOften(labeler, scene.Update(), StandingAt(1, 0));
  // For a single frame the second region is a platform that the robot cannot step onto.
  LabelScene after;
  after.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 2);
  after.AddLevel(TerrainLabel::kWalkway, {5.6, 0, 0.6}, 4, 2);
  PolygonUpdate update = after.Update();
  update.added.clear();
  update.revised = {1, 2};
  labeler.Label(update, StandingAt(1, 0), TestGravity());
  const RegionExplanation e = Explained(labeler, 2);
  EXPECT_EQ(e.label, TerrainLabel::kWalkway);
  EXPECT_EQ(e.rule, LabelRule::kReachableGround);
  EXPECT_EQ(e.next_label, TerrainLabel::kLevel);
  EXPECT_EQ(e.num_next, 1);
  EXPECT_THAT(e.text, HasSubstr("The last 1 frame found it to be level"));
}

TEST(ExplanationTest, KnowsNothingOfIdsThatAreNotThere) {
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_TRUE(labeler.Explain(7).regions.empty());
  EXPECT_TRUE(labeler.Explain().staircases.empty());
}

TEST(ExplanationTest, NamesEveryRuleWithAWordOfItsOwn) {
  for (int i = 0; i < kNumLabelRules; ++i) {
    const auto rule = static_cast<LabelRule>(i);
    EXPECT_EQ(LabelRuleFromName(Name(rule)), rule) << i;
  }
  EXPECT_EQ(LabelRuleFromName("by chance"), std::nullopt);
}

}  // namespace
}  // namespace terrace
