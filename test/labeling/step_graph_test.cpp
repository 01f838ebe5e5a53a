// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/step_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

using testing::ElementsAre;

constexpr StepLimits kStepLimits{0.35, 0.20, 0.10, 0.04};

std::vector<RegionShapePtr> GraphShapes(const LabelScene& scene) {
  std::vector<RegionShapePtr> shapes;
  for (const PolygonPtr& polygon : scene.Update().changed)
    shapes.push_back(MakeRegionShape(polygon, Eigen::Matrix3d::Identity(), {0.52, 1.13, 0.5}));
  return shapes;
}

/// Between a square of one metre and another, this far beyond its edge and this much higher.
Link LinkAcross(double gap_m, double height_m) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {0, 0, 0}, 1, 1);
  scene.AddLevel(TerrainLabel::kWalkway, {1.0 + gap_m, 0.2, height_m}, 1, 1);
  const auto shapes = GraphShapes(scene);
  const Link link = LinkBetween(*shapes[0], *shapes[1], kStepLimits);
  EXPECT_EQ(LinkBetween(*shapes[1], *shapes[0], kStepLimits), link);
  return link;
}

TEST(StepGraphTest, JoinsWhatIsOneGroundAndStepsAsFarAsTheRobotCan) {
  EXPECT_EQ(LinkAcross(0.05, 0.02), Link::kJoins);
  EXPECT_EQ(LinkAcross(0.05, 0.06), Link::kStep);
  EXPECT_EQ(LinkAcross(0.20, 0.02), Link::kStep);
  EXPECT_EQ(LinkAcross(0.30, -0.18), Link::kStep);
  EXPECT_EQ(LinkAcross(0.05, 0.22), Link::kNone);
  EXPECT_EQ(LinkAcross(0.40, 0.0), Link::kNone);
}

TEST(StepGraphTest, ReachesOverChainsOfStepsAndOverExtraPairs) {
  LabelScene scene;
  for (int i = 0; i < 3; ++i) scene.AddLevel(TerrainLabel::kWalkway, {1.1 * i, 0, 0.15 * i}, 1, 1);
  scene.AddLevel(TerrainLabel::kWalkway, {6, 0, 0}, 1, 1);
  StepGraph graph(kStepLimits);
  graph.Update(GraphShapes(scene));
  EXPECT_THAT(graph.Reachable({0}, {}), ElementsAre(true, true, true, false));
  EXPECT_THAT(graph.Reachable({0}, {{3, 2}}), ElementsAre(true, true, true, true));
  EXPECT_THAT(graph.Reachable({3}, {}), ElementsAre(false, false, false, true));
}

TEST(StepGraphTest, FollowsAShapeThatHasMoved) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {0, 0, 0}, 1, 1);
  scene.AddLevel(TerrainLabel::kWalkway, {1.1, 0, 0}, 1, 1);
  StepGraph graph(kStepLimits);
  std::vector<RegionShapePtr> shapes = GraphShapes(scene);
  graph.Update(shapes);
  graph.Update(shapes);
  EXPECT_EQ(graph.neighbors()[0].size(), 1u);
  for (Eigen::Vector3d& p : scene.pieces[1].outline) p.x() += 2.0;
  graph.Update({shapes[0], GraphShapes(scene)[1]});
  EXPECT_TRUE(graph.neighbors()[0].empty());
}

}  // namespace
}  // namespace terrace
