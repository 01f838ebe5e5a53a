// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/edge_kinds.h"

#include <cmath>

#include <gtest/gtest.h>

#include "label_scene.h"
#include "labeling/drop_view.h"

namespace terrace {
namespace {

const Eigen::Matrix3d kLevelWorld = Eigen::Matrix3d::Identity();

/// The platform is piece 1: from x = 0 to 3, y = -1 to 1, at z = 0. Its edge k begins at corner k: 0 right, 1
/// far, 2 left, 3 near.
LabelScene Platform() {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1.5, 0, 0}, 3, 2);
  return scene;
}

std::vector<RegionShapePtr> EdgeShapes(const LabelScene& scene) {
  std::vector<RegionShapePtr> shapes;
  for (const PolygonPtr& polygon : scene.Update().changed)
    shapes.push_back(MakeRegionShape(polygon, kLevelWorld, {0.52, 1.13, 0.5}));
  return shapes;
}

std::vector<RegionEdge> PlatformEdges(const LabelScene& scene, const Eigen::Vector3d& eye,
                                      TopView tops = TopView::kSeen) {
  const auto shapes = EdgeShapes(scene);
  return EdgesOf(0, shapes, std::vector<TopView>(shapes.size(), tops), kLevelWorld, eye);
}

/// 1.2 m before the far edge.
const Eigen::Vector3d kEyeBefore(1.8, 0.0, 0.45);

TEST(EdgeKindsTest, TellsADropAndItsDepthByTheLowerGroundSeenOverTheEdge) {
  for (const double depth : {0.3, 0.8, 2.0}) {
    LabelScene scene = Platform();
    // The strip behind the edge is hidden: x where the line of sight over the edge meets the ground.
    const double hidden_until = kEyeBefore.x() + 1.2 * (1.0 + depth / kEyeBefore.z());
    scene.AddLevel(TerrainLabel::kLevel, {hidden_until + 2.0, 0, -depth}, 4, 4);
    const auto edges = PlatformEdges(scene, kEyeBefore);
    ASSERT_EQ(edges.size(), 4u);
    EXPECT_EQ(edges[1].kind, EdgeKind::kDrop);
    ASSERT_TRUE(edges[1].step_m);
    EXPECT_NEAR(*edges[1].step_m, -depth, 1e-3);
    EXPECT_GT(*edges[1].sigma_m, 0.0);
    for (const int other : {0, 2, 3}) EXPECT_EQ(edges[other].kind, EdgeKind::kLimitOfView);
  }
}

TEST(EdgeKindsTest, TellsADropOfUnknownDepthWhereOnlyAWallIsSeenOverTheEdge) {
  LabelScene scene = Platform();
  scene.AddFace(TerrainLabel::kWall, {5, 2, -3}, {5, -2, -3}, 4.0);
  const auto edges = PlatformEdges(scene, kEyeBefore);
  EXPECT_EQ(edges[1].kind, EdgeKind::kDrop);
  EXPECT_FALSE(edges[1].step_m);
}

TEST(EdgeKindsTest, TellsADropOfUnknownDepthWherePixelsLookPastTheGroundFromNear) {
  LabelScene scene = Platform();
  std::vector<RegionShapePtr> shapes = EdgeShapes(scene);
  Polygon polygon = *shapes[0]->polygon;
  polygon.seen_past = {false, true, false, false};
  shapes[0] = MakeRegionShape(std::make_shared<const Polygon>(polygon), kLevelWorld, {0.52, 1.13, 0.5});
  const auto edges_from = [&](const Eigen::Vector3d& eye) {
    return EdgesOf(0, shapes, {TopView::kSeen}, kLevelWorld, eye);
  };
  const auto edges = edges_from(kEyeBefore);
  EXPECT_EQ(edges[1].kind, EdgeKind::kDrop);
  EXPECT_FALSE(edges[1].step_m);
  for (const int other : {0, 2, 3}) EXPECT_EQ(edges[other].kind, EdgeKind::kLimitOfView);
  EXPECT_EQ(edges_from({-1.0, 0.0, 0.45})[1].kind, EdgeKind::kLimitOfView);
}

TEST(EdgeKindsTest, TellsNoDropWhereAWallStandsOnGroundThatWasNotSeen) {
  LabelScene scene = Platform();
  scene.AddFace(TerrainLabel::kWall, {3.6, 2, 0}, {3.6, -2, 0}, 2.0);
  EXPECT_EQ(PlatformEdges(scene, kEyeBefore)[1].kind, EdgeKind::kLimitOfView);
}

TEST(EdgeKindsTest, DoesNotTakeAScrapOfAMirrorImageBelowTheFloorForADrop) {
  LabelScene scene = Platform();
  scene.AddLevel(TerrainLabel::kLevel, {5, 0, -0.8}, 0.15, 0.15);
  EXPECT_EQ(PlatformEdges(scene, kEyeBefore)[1].kind, EdgeKind::kLimitOfView);
}

TEST(EdgeKindsTest, MeasuresSmallStepsUpAndDownAndWhereGroundGoesOn) {
  LabelScene scene = Platform();
  scene.AddLevel(TerrainLabel::kWalkway, {3.55, 0, -0.12}, 1, 2);              // a step down at the far edge
  scene.AddLevel(TerrainLabel::kWalkway, {1.5, 1.52, 0.01}, 3, 1);             // goes on at the left
  scene.AddFace(TerrainLabel::kObstacle, {0, -1.02, 0}, {3, -1.02, 0}, 0.15);  // a kerb at the right
  const auto edges = PlatformEdges(scene, kEyeBefore);
  EXPECT_EQ(edges[0].kind, EdgeKind::kRise);
  EXPECT_NEAR(edges[0].step_m.value_or(0.0), 0.15, 1e-3);
  EXPECT_EQ(edges[1].kind, EdgeKind::kDrop);
  EXPECT_NEAR(edges[1].step_m.value_or(0.0), -0.12, 1e-3);
  EXPECT_EQ(edges[2].kind, EdgeKind::kJoins);
  EXPECT_NEAR(edges[2].step_m.value_or(1.0), 0.01, 1e-3);
  // How high a face is of which the top was not in view is not known.
  EXPECT_FALSE(PlatformEdges(scene, kEyeBefore, TopView::kOutOfView)[0].step_m);
}

TEST(EdgeKindsTest, KeepsADropThatIsNoLongerInView) {
  const PolygonPtr polygon = Platform().Update().changed[0];
  TerrainRegion before;
  before.outline_world = polygon->outline_world;
  before.edges.assign(4, {});
  before.edges[1] = {EdgeKind::kDrop, -0.8, 0.02};
  std::vector<RegionEdge> edges(4);
  edges[0] = {EdgeKind::kJoins, 0.0, 0.01};
  KeepKnownDrops(before, *polygon, edges);
  EXPECT_EQ(edges[0].kind, EdgeKind::kJoins);
  EXPECT_EQ(edges[1], before.edges[1]);
  EXPECT_EQ(edges[2].kind, EdgeKind::kLimitOfView);
}

}  // namespace
}  // namespace terrace
