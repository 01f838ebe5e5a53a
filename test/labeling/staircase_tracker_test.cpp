// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_tracker.h"

#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

constexpr int kFrames = 3;

/// Faces of a flight of six risers in x from (3, 0, 0), and what was found of it.
class StaircaseTrackerTest : public testing::Test {
 protected:
  StaircaseTrackerTest() : table_({0.52, 1.13, 0.5}, 0.003), tracker_(kFrames) {
    LabelScene scene;
    for (int k = 1; k <= 6; ++k) {
      const double x = 3.0 + 0.28 * (k - 1), z = 0.17 * (k - 1);
      scene.AddFace(TerrainLabel::kStairRiser, {x, 0.6, z}, {x, -0.6, z}, 0.17, k);
    }
    table_.Update(scene.Update(), TestGravity(), {1, 0, 0.5});
  }

  /// As it is found when risers `first` to `last` are seen, which are counted from 1 then.
  static FoundStaircase Found(int first, int last) {
    FoundStaircase found;
    found.model.origin = {3.0 + 0.28 * (first - 1), 0.0};
    found.model.foot_z = 0.17 * (first - 1);
    found.model.rise_m = 0.17;
    found.model.run_m = 0.28;
    found.model.lateral = {-0.6, 0.6};
    found.num_risers = last - first + 1;
    found.num_treads = found.num_risers - 1;
    found.rise_sigma_m = 0.003;
    found.run_sigma_m = 0.004;
    found.confidence = 0.8;
    for (int k = first; k <= last; ++k) found.members.push_back({k - 1, true, k - first + 1});
    return found;
  }

  void See(const FoundStaircase& found, int times = 1) {
    for (int i = 0; i < times; ++i) tracker_.Update({found}, table_);
  }
  const Staircase& told() const { return tracker_.confirmed().begin()->second.published; }

  ShapeTable table_;
  StaircaseTracker tracker_;
};

TEST_F(StaircaseTrackerTest, TellsAStaircaseAfterSomeFramesInARow) {
  See(Found(1, 6), kFrames - 1);
  EXPECT_TRUE(tracker_.confirmed().empty());
  See(Found(1, 6));
  ASSERT_EQ(tracker_.confirmed().size(), 1u);
  EXPECT_EQ(told().id, 1);
  EXPECT_EQ(told().num_risers, 6);
  EXPECT_NEAR((told().base_world() - Eigen::Vector3d(3, 0, 0)).norm(), 0.0, 1e-9);
}

TEST_F(StaircaseTrackerTest, TellsAStaircaseAfterTwoFramesThatLeaveLittleDoubt) {
  FoundStaircase sure = Found(1, 6);
  sure.confidence = 0.9;
  See(sure);
  EXPECT_TRUE(tracker_.confirmed().empty());
  tracker_.Update({}, table_);  // the doubt is back
  See(sure);
  EXPECT_TRUE(tracker_.confirmed().empty());
  See(sure);
  EXPECT_EQ(tracker_.confirmed().size(), 1u);
}

TEST_F(StaircaseTrackerTest, DoubtsStepsBetweenAFloorAndALandingLess) {
  FoundStaircase found = Found(2, 5);
  found.confidence = 0.78;
  See(found, 2);
  EXPECT_TRUE(tracker_.confirmed().empty());
  StaircaseTracker other(kFrames);
  found.foot_shape = 0;
  found.head_shape = 5;
  for (int i = 0; i < 2; ++i) other.Update({found}, table_);
  EXPECT_EQ(other.confirmed().size(), 1u);
}

TEST_F(StaircaseTrackerTest, DoesNotTellWhatIsFoundNowAndThen) {
  for (int i = 0; i < 5; ++i) {
    See(Found(1, 6), kFrames - 1);
    tracker_.Update({}, table_);
    EXPECT_TRUE(tracker_.confirmed().empty());
  }
}

TEST_F(StaircaseTrackerTest, KeepsTheCountWhileStepsAtEitherEndAreHidden) {
  See(Found(1, 6), kFrames);
  See(Found(1, 4), 5);
  EXPECT_EQ(told().num_risers, 6);
  See(Found(3, 6), 5);
  EXPECT_EQ(told().num_risers, 6);
  EXPECT_NEAR(told().base_world().x(), 3.0, 1e-6);
  EXPECT_EQ(tracker_.confirmed().begin()->second.places.back().step_index, 6);
}

TEST_F(StaircaseTrackerTest, KeepsTheStepsAtTheFootWhileMoreAppearAtTheTop) {
  See(Found(1, 4), kFrames);
  See(Found(2, 6), 2 * kFrames);
  EXPECT_EQ(told().num_risers, 6);
  EXPECT_NEAR(told().base_world().x(), 3.0, 1e-6);
  EXPECT_NEAR(told().base_world().z(), 0.0, 1e-6);
}

TEST_F(StaircaseTrackerTest, BelievesMoreStepsWhenTheyAreSeenForSomeTime) {
  See(Found(1, 4), kFrames);
  See(Found(1, 6));
  EXPECT_EQ(told().num_risers, 4);
  See(Found(1, 6), kFrames);
  EXPECT_EQ(told().num_risers, 6);
  EXPECT_EQ(told().id, 1);
}

TEST_F(StaircaseTrackerTest, TakesNumbersThatAreAnyBetterWhileAFlightWasJustFound) {
  FoundStaircase better = Found(1, 6);
  better.model.rise_m += 0.004;
  better.rise_sigma_m *= 0.9;
  See(Found(1, 6), kFrames);
  See(better);
  EXPECT_NEAR(told().riser_m, 0.174, 1e-12);
  better.model.rise_m += 0.002;
  better.rise_sigma_m *= 0.9;
  See(Found(1, 6), 2 * kFrames);
  See(better);
  EXPECT_NEAR(told().riser_m, 0.174, 1e-12);
}

TEST_F(StaircaseTrackerTest, RestsWhileNewNumbersSayNothingBetter) {
  See(Found(1, 6), kFrames);
  FoundStaircase other = Found(1, 6);
  other.model.rise_m += 0.004;
  other.model.run_m -= 0.005;
  See(other, 10);
  EXPECT_EQ(told().riser_m, 0.17);
  EXPECT_EQ(told().tread_m, 0.28);
  other.rise_sigma_m = other.run_sigma_m = 0.001;
  See(other);
  EXPECT_NEAR(told().riser_m, 0.174, 1e-12);
}

TEST_F(StaircaseTrackerTest, RestsWhileTheFootIsAsWellKnownAsWhatIsSeenFarFromItTells) {
  FoundStaircase far = Found(1, 6);
  std::erase_if(far.members, [](const StepMember& member) { return member.step_index < 5; });
  far.run_sigma_m = 0.01;
  See(far, kFrames);
  FoundStaircase other = far;
  other.model.origin.x() += 0.05;  // five steps of a centimetre that nobody knows
  See(other, kFrames);
  EXPECT_NEAR(told().base_world().x(), 3.0, 1e-9);
  FoundStaircase near = other;
  near.members = Found(1, 6).members;
  near.run_sigma_m = 0.004;
  See(near);
  EXPECT_NEAR(told().base_world().x(), 3.05, 1e-9);
}

TEST_F(StaircaseTrackerTest, KeepsTheWidthWhileASideIsOutOfView) {
  See(Found(1, 6), kFrames);
  FoundStaircase part = Found(1, 6);
  part.model.lateral = {-0.1, 0.6};
  part.rise_sigma_m = part.run_sigma_m = 0.001;  // better known otherwise
  See(part, kFrames);
  EXPECT_NEAR(told().width_m, 1.2, 1e-9);
}

TEST_F(StaircaseTrackerTest, TellsTheTreadOfASpiralAtTheMiddleOfAllOfItsWidthThatEverShowed) {
  FoundStaircase spiral = Found(1, 6);
  spiral.model.spiral = true;
  spiral.model.direction = Eigen::Vector2d(0.0, -1.0);
  spiral.model.run_m = 0.4;
  spiral.model.radius_m = 1.0;
  spiral.model.lateral = {0.6, 1.4};
  See(spiral, kFrames);
  EXPECT_NEAR(told().tread_m, 0.4, 1e-12);
  FoundStaircase wider = spiral;
  wider.model.lateral.low = 0.2;
  See(wider);
  EXPECT_NEAR(told().tread_m, 0.32, 1e-12);
  EXPECT_NEAR(told().tread_sigma_m, 0.8 * spiral.run_sigma_m, 1e-12);
  EXPECT_NEAR(told().turn_per_step_rad, 0.4, 1e-12);
  See(spiral, 10);
  EXPECT_NEAR(told().width_m, 1.2, 1e-12);
}

TEST_F(StaircaseTrackerTest, BelievesAnotherLawAtOnceOnlyWhenItIsBetterKnown) {
  See(Found(1, 6), kFrames);
  FoundStaircase worse = Found(1, 6);
  worse.model.run_m = 0.36;
  worse.run_sigma_m = 0.02;
  See(worse, 2 * kFrames);
  EXPECT_EQ(told().tread_m, 0.28) << "badly known, and against all that was seen";
  See(Found(1, 6));
  FoundStaircase other = Found(1, 6);
  other.model.run_m = 0.30;
  See(other, kFrames - 1);
  EXPECT_EQ(told().tread_m, 0.28);
  See(Found(1, 6));
  See(other, kFrames - 1);
  EXPECT_EQ(told().tread_m, 0.28) << "not often enough in a row";
  See(other);
  EXPECT_EQ(told().tread_m, 0.30);
  FoundStaircase better = Found(1, 6);
  better.run_sigma_m = 0.001;
  See(better);
  EXPECT_EQ(told().tread_m, 0.28);
}

TEST_F(StaircaseTrackerTest, SaysThatAFlightIsContestedUntilFramesInARowHaveDecided) {
  See(Found(2, 5), kFrames);
  EXPECT_FALSE(tracker_.contested());
  See(Found(2, 6));
  EXPECT_TRUE(tracker_.contested()) << "more steps";
  See(Found(2, 5));
  EXPECT_FALSE(tracker_.contested());
  See(Found(2, 6), kFrames);
  EXPECT_FALSE(tracker_.contested()) << "believed by now";
  See(Found(2, 4), kFrames);
  EXPECT_FALSE(tracker_.contested()) << "some are hidden";
  FoundStaircase other = Found(2, 6);
  other.model.run_m = 0.31;
  See(other);
  EXPECT_TRUE(tracker_.contested()) << "another law";
  See(other, kFrames);
  EXPECT_FALSE(tracker_.contested());
}

TEST_F(StaircaseTrackerTest, BelievesNoOtherRiseForARunThatIsBetterKnown) {
  See(Found(1, 6), kFrames);
  FoundStaircase other = Found(1, 6);
  other.model.rise_m = 0.155;
  other.rise_sigma_m = 0.010;
  other.run_sigma_m = 0.001;
  See(other, 2 * kFrames);
  EXPECT_EQ(told().riser_m, 0.17);
}

TEST_F(StaircaseTrackerTest, ForgetsOneThatIsNoLongerFoundAndNeverUsesItsIdAgain) {
  See(Found(1, 6), kFrames);
  for (int i = 0; i < kFrames; ++i) tracker_.Update({}, table_);
  EXPECT_EQ(tracker_.confirmed().size(), 1u);
  tracker_.Update({}, table_);
  EXPECT_TRUE(tracker_.confirmed().empty());
  See(Found(1, 6), kFrames);
  EXPECT_EQ(told().id, 2);
}

TEST_F(StaircaseTrackerTest, SleepsWhileNothingOfItIsLookedAtAndLosesWhatIsRemoved) {
  See(Found(1, 6), kFrames);
  const Eigen::Vector3d far_away(60, 0, 0.5);
  for (int i = 0; i < 3 * kFrames; ++i) {
    table_.Update({}, TestGravity(), far_away);
    EXPECT_TRUE(tracker_.Models(table_).empty());
    tracker_.Update({}, table_);
    ASSERT_EQ(tracker_.confirmed().size(), 1u) << "it was not missed: nobody looked";
  }
  EXPECT_TRUE(tracker_.looked_at().empty());
  PolygonUpdate update;
  update.removed = {6};
  table_.Update(update, TestGravity(), far_away);
  tracker_.Models(table_);
  tracker_.Update({}, table_);
  ASSERT_EQ(tracker_.looked_at().size(), 1u);
  EXPECT_EQ(told().region_ids, (std::vector<std::int64_t>{1, 2, 3, 4, 5}));
  // Coming back, it is found under its id.
  table_.Update({}, TestGravity(), {1, 0, 0.5});
  EXPECT_EQ(tracker_.Models(table_).size(), 1u);
  See(Found(1, 5));
  ASSERT_EQ(tracker_.confirmed().size(), 1u);
  EXPECT_EQ(told().id, 1);
}

TEST_F(StaircaseTrackerTest, SaysWhichStaircasesHaveGone) {
  See(Found(1, 6), kFrames);
  PolygonUpdate update;
  update.removed = {1, 2, 3, 4, 5, 6};
  table_.Update(update, TestGravity(), {60, 0, 0.5});
  tracker_.Update({}, table_);
  EXPECT_EQ(tracker_.removed(), std::vector<std::int64_t>{1});
  EXPECT_TRUE(tracker_.confirmed().empty());
}

}  // namespace
}  // namespace terrace
