// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/reachability.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

constexpr StepLimits kReachLimits{0.35, 0.20, 0.10, 0.04};

std::vector<RegionShapePtr> ReachShapes(const LabelScene& scene) {
  std::vector<RegionShapePtr> shapes;
  for (const PolygonPtr& polygon : scene.Update().changed)
    shapes.push_back(MakeRegionShape(polygon, Eigen::Matrix3d::Identity(), {0.52, 1.13, 0.5}));
  return shapes;
}

std::vector<bool> ReachedFromFirst(const LabelScene& scene,
                                   const std::vector<std::pair<int, int>>& links = {}) {
  const std::vector<RegionShapePtr> shapes = ReachShapes(scene);
  StepGraph graph(kReachLimits);
  graph.Update(shapes);
  return ReachableFrom({0}, links, graph, shapes, LabelingConfig{});
}

/// Two floors of 2 m with a strip of this width between them that nothing was seen of.
LabelScene FloorsApart(double strip_m) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {0, 0, 0}, 2, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {2.0 + strip_m, 0, 0}, 2, 2);
  return scene;
}

TEST(ReachabilityTest, GroundGoesOnBehindAStripThatWasNotSeen) {
  const double unseen_m = LabelingConfig{}.max_unseen_gap_m;
  ASSERT_GT(unseen_m, 0.4) << "farther than a step, or the test says nothing";
  EXPECT_THAT(ReachedFromFirst(FloorsApart(0.9 * unseen_m)), ElementsAre(true, true));
  EXPECT_THAT(ReachedFromFirst(FloorsApart(1.2 * unseen_m)), ElementsAre(true, false));
}

TEST(ReachabilityTest, ADitchBetweenFloorsIsNoStripThatWasNotSeen) {
  const double strip_m = 0.9 * LabelingConfig{}.max_unseen_gap_m;
  LabelScene scene = FloorsApart(strip_m);
  scene.AddLevel(TerrainLabel::kWalkway, {1.0 + 0.5 * strip_m, 0, -0.6}, strip_m, 2);
  EXPECT_THAT(ReachedFromFirst(scene), ElementsAre(true, false, false));
}

TEST(ReachabilityTest, GroundGoesOnOverOneStripAfterTheOther) {
  const double pace_m = 2.0 + 0.9 * LabelingConfig{}.max_unseen_gap_m;
  LabelScene scene;
  for (const int i : {0, 3, 1, 2}) scene.AddLevel(TerrainLabel::kWalkway, {pace_m * i, 0, 0}, 2, 2);
  EXPECT_THAT(ReachedFromFirst(scene), ElementsAre(true, true, true, true));
}

TEST(ReachabilityTest, LinksLeadToWhatNoStepReaches) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {0, 0, 0}, 2, 2);
  scene.AddLevel(TerrainLabel::kWalkway, {2, 0, 1.0}, 2, 2);
  EXPECT_THAT(ReachedFromFirst(scene), ElementsAre(true, false));
  EXPECT_THAT(ReachedFromFirst(scene, {{1, 0}}), ElementsAre(true, true));
}

/// A floor, treads 1 and 3, and a landing above riser 4, as regions 1 to 4; tread 2 was not seen.
TrackedStaircase StairsWithoutTread2(double riser_m) {
  TrackedStaircase stairs;
  stairs.places = {{2, false, 1, false}, {3, false, 3, false}};
  stairs.foot_region = 1;
  stairs.head_region = 4;
  stairs.published.riser_m = riser_m;
  stairs.published.num_risers = 4;
  return stairs;
}

class StairLinksTest : public testing::Test {
 protected:
  StairLinksTest() : table_({0.52, 1.13, 0.5}, 0.01) {
    LabelScene scene;
    scene.AddLevel(TerrainLabel::kWalkway, {0, 0, 0}, 1, 1);
    scene.AddLevel(TerrainLabel::kStairTread, {0.64, 0, 0.17}, 0.28, 1);
    scene.AddLevel(TerrainLabel::kStairTread, {1.2, 0, 0.51}, 0.28, 1);
    scene.AddLevel(TerrainLabel::kWalkway, {1.84, 0, 0.68}, 1, 1);
    table_.Update(scene.Update(), TestGravity(), Eigen::Vector3d(0, 0, 0.5));
  }

  ShapeTable table_;
};

TEST_F(StairLinksTest, JoinFootTreadsAndHeadOverStepsThatWereNotSeen) {
  const TrackedStaircase stairs = StairsWithoutTread2(0.17);
  EXPECT_THAT(StairLinks({&stairs}, table_, RobotConfig{}), ElementsAre(Pair(0, 1), Pair(1, 2), Pair(2, 3)));
}

TEST_F(StairLinksTest, LeaveOutWhatIsNoPlaceToStepOnOrNotLookedAt) {
  TrackedStaircase stairs = StairsWithoutTread2(0.17);
  stairs.places.front().only_evidence = true;
  stairs.head_region = 99;
  EXPECT_THAT(StairLinks({&stairs}, table_, RobotConfig{}), ElementsAre(Pair(0, 2)));
}

TEST_F(StairLinksTest, LeadNowhereWhereRisersAreHigherThanTheRobotSteps) {
  const RobotConfig robot;
  const TrackedStaircase stairs = StairsWithoutTread2(robot.max_step_height_m + 0.05);
  EXPECT_THAT(StairLinks({&stairs}, table_, robot), IsEmpty());
}

}  // namespace
}  // namespace terrace
