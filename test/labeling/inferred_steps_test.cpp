// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/inferred_steps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

constexpr double kKnownRise = 0.17, kKnownRun = 0.28;

/// Five risers up in x from the origin, of which the first two faces were seen, and the floor before them.
TrackedStaircase TwoFacesSeen() {
  TrackedStaircase stairs;
  stairs.id = 1;
  FlightModel& model = stairs.found.model;
  model.rise_m = kKnownRise;
  model.run_m = kKnownRun;
  model.lateral = {-0.6, 0.6};
  stairs.found.num_risers = 5;
  stairs.found.num_treads = 4;
  stairs.found.rise_sigma_m = 0.003;
  stairs.found.run_sigma_m = 0.004;
  stairs.places = {{1, true, 1}, {2, true, 2}};
  stairs.foot_region = 3;
  return stairs;
}

std::vector<RegionShapePtr> ShapesIn(const LabelScene& scene) {
  std::vector<RegionShapePtr> shapes;
  for (const PolygonPtr& polygon : scene.Update().changed)
    shapes.push_back(MakeRegionShape(polygon, Eigen::Matrix3d::Identity(), {0.52, 1.13, 0.5}));
  return shapes;
}

/// Faces 1 and 2, and the floor up to the first.
LabelScene SeenOfIt() {
  LabelScene scene;
  for (int k = 1; k <= 2; ++k) {
    const double x = (k - 1) * kKnownRun, z = (k - 1) * kKnownRise;
    scene.AddFace(TerrainLabel::kStairRiser, {x, 0.6, z}, {x, -0.6, z}, kKnownRise, k);
  }
  scene.AddLevel(TerrainLabel::kWalkway, {-1.5, 0, 0}, 3, 2);
  return scene;
}

const InferredStep* Find(const std::vector<InferredStep>& steps, bool riser, int k) {
  for (const InferredStep& step : steps)
    if (step.riser == riser && step.step_index == k) return &step;
  return nullptr;
}

TEST(InferredStepsTest, AreAllTreadsAndRisersThatTheLawDemandsAndTheStripOfLanding) {
  const auto steps = InferSteps(TwoFacesSeen(), ShapesIn(SeenOfIt()));
  for (int k = 1; k <= 5; ++k) {
    EXPECT_EQ(Find(steps, true, k) != nullptr, k > 2) << "riser " << k;
    const InferredStep* tread = Find(steps, false, k);
    ASSERT_TRUE(tread) << "tread " << k;
    EXPECT_NEAR(tread->plane.offset_m, k * kKnownRise, 1e-12);
    EXPECT_NEAR(SignedArea(tread->outline, tread->plane.normal), 1.2 * kKnownRun, 1e-9);
    for (const Eigen::Vector3d& p : tread->outline) {
      EXPECT_NEAR(tread->plane.SignedDistance(p), 0.0, 1e-12);
      EXPECT_GT(p.x(), (k - 1) * kKnownRun - 1e-9);
      EXPECT_LT(p.x(), k * kKnownRun + 1e-9);
    }
  }
  const InferredStep* riser = Find(steps, true, 4);
  EXPECT_NEAR(SignedArea(riser->outline, riser->plane.normal), 1.2 * kKnownRise, 1e-9);
  EXPECT_NEAR(riser->plane.normal.x(), -1.0, 1e-12);
  for (const Eigen::Vector3d& p : riser->outline) EXPECT_NEAR(riser->plane.SignedDistance(p), 0.0, 1e-12);
}

TEST(InferredStepsTest, AreLessCertainTheFartherTheyLieFromWhatWasSeen) {
  const auto steps = InferSteps(TwoFacesSeen(), ShapesIn(SeenOfIt()));
  double last = 0.0;
  for (int k = 2; k <= 5; ++k) {
    EXPECT_GT(Find(steps, false, k)->height_sigma_m, last);
    last = Find(steps, false, k)->height_sigma_m;
  }
  TrackedStaircase vague = TwoFacesSeen();
  vague.found.rise_sigma_m = 0.012;
  EXPECT_TRUE(Find(InferSteps(vague, ShapesIn(SeenOfIt())), false, 2));
  EXPECT_FALSE(Find(InferSteps(vague, ShapesIn(SeenOfIt())), false, 5));
}

TEST(InferredStepsTest, AreReplacedByWhatWasSeenAndFillTheRest) {
  LabelScene scene = SeenOfIt();
  scene.AddLevel(TerrainLabel::kStairTread, {0.14, 0, kKnownRise}, kKnownRun, 1.2);  // all of tread 1
  scene.AddLevel(TerrainLabel::kStairTread, {0.35, 0, 2 * kKnownRise}, 0.14,
                 1.2);  // the front half of tread 2
  const auto steps = InferSteps(TwoFacesSeen(), ShapesIn(scene));
  EXPECT_FALSE(Find(steps, false, 1));
  const InferredStep* rest = Find(steps, false, 2);
  ASSERT_TRUE(rest);
  for (const Eigen::Vector3d& p : rest->outline) EXPECT_GT(p.x(), 0.42 - 0.03);
}

TEST(InferredStepsTest, EndWhereEvidenceSaysOtherwise) {
  LabelScene scene = SeenOfIt();
  scene.AddFace(TerrainLabel::kWall, {0.75, 1, 0}, {0.75, -1, 0}, 2.0);  // a wall across tread 3
  scene.AddLevel(TerrainLabel::kObstacle, {0.14, 0.3, kKnownRise + 0.3}, 0.28,
                 0.6);                                              // a box's top over half of tread 1
  scene.AddLevel(TerrainLabel::kWalkway, {1.26, 0, 0}, 0.28, 1.2);  // floor seen below the landing
  const auto steps = InferSteps(TwoFacesSeen(), ShapesIn(scene));
  for (const Eigen::Vector3d& p : Find(steps, false, 1)->outline) EXPECT_LT(p.y(), 0.05);
  EXPECT_TRUE(Find(steps, false, 2));
  const InferredStep* cut = Find(steps, false, 3);
  ASSERT_TRUE(cut);
  for (const Eigen::Vector3d& p : cut->outline) EXPECT_LT(p.x(), 0.75);
  EXPECT_FALSE(Find(steps, false, 5));
}

TEST(InferredStepsTest, HaveNoRisersWhereNoneWasSeen) {
  TrackedStaircase open = TwoFacesSeen();
  open.places = {{1, false, 1}, {2, false, 2}};
  const auto steps = InferSteps(open, {});
  for (int k = 1; k <= 5; ++k) EXPECT_FALSE(Find(steps, true, k));
}

}  // namespace
}  // namespace terrace
