// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/terrain_labeler.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

using enum TerrainLabel;

constexpr double kPi = std::numbers::pi;

LabelScene Corridor() {
  LabelScene scene;
  scene.AddLevel(kWalkway, {3, 0, 0}, 8, 2);
  scene.AddFace(kWall, {-1, 1, 0}, {7, 1, 0}, 2.6);
  scene.AddFace(kWall, {7, -1, 0}, {-1, -1, 0}, 2.6);
  return scene;
}

LabelScene StairsUp() {
  LabelScene scene = Corridor();
  KnownFlight flight;
  flight.foot = {7, 0, 0};
  scene.AddFlight(flight);
  scene.AddLevel(kWalkway, {9.9, 0, 1.02}, 3, 2);
  return scene;
}

/// Takes polygons out of an update.
template <typename Which>
void Remove(PolygonUpdate* update, const Which& which) {
  std::erase_if(update->changed, [&](const PolygonPtr& polygon) {
    if (!which(polygon)) return false;
    update->removed.push_back(polygon->id);
    return true;
  });
}

TEST(TerrainLabelerTest, LabelsFloorAndWallsOfACorridor) {
  const LabelScene scene = Corridor();
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(0, 0))), "");
}

TEST(TerrainLabelerTest, LabelsBoxesAsObstacles) {
  LabelScene scene = Corridor();
  scene.AddBox({4, 0.5, 0}, 0.6, 0.36, 0.4, 0.04);
  scene.AddBox({5, -0.6, 0}, 0.36, 0.3, 0.15, 0.3);
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(0, 0))), "");
}

TEST(TerrainLabelerTest, FindsAStaircaseGoingUpWithRightDimensions) {
  const LabelScene scene = StairsUp();
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update(), StandingAt(5, 0));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  ASSERT_EQ(map->staircases.size(), 1u);
  const Staircase& s = map->staircases[0];
  EXPECT_EQ(s.num_risers, 6);
  EXPECT_EQ(s.num_treads, 5);
  EXPECT_NEAR(s.riser_m, 0.17, 1e-3);
  EXPECT_NEAR(s.tread_m, 0.28, 1e-3);
  EXPECT_NEAR(s.width_m, 1.4, 1e-3);
  EXPECT_LT((s.base_world() - Eigen::Vector3d(7, 0, 0)).norm(), 1e-3);
  EXPECT_LT((s.direction_up_world - Eigen::Vector3d::UnitX()).norm(), 1e-3);
  EXPECT_NEAR(s.foot_edge_world[0].y(), 0.7, 1e-3);
  EXPECT_NEAR(s.head_edge_world[1].y(), -0.7, 1e-3);
  EXPECT_NEAR(s.head_edge_world[1].z(), 1.02, 2e-3);
  EXPECT_GT(s.confidence, 0.8);
}

TEST(TerrainLabelerTest, FindsAStaircaseInEveryDirection) {
  for (double yaw = 0.1; yaw < 2.0 * kPi; yaw += 0.7) {
    LabelScene scene;
    scene.AddLevel(kWalkway, {0, 0, 0}, 3, 3, yaw);
    KnownFlight flight;
    flight.yaw_rad = yaw;
    flight.foot = 1.5 * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);
    scene.AddFlight(flight);
    const double far = 1.5 + 5 * 0.28 + 1.0;
    scene.AddLevel(kWalkway, {far * std::cos(yaw), far * std::sin(yaw), 1.02}, 2, 2, yaw);
    TerrainLabeler labeler = MakeLabeler();
    const TerrainMapPtr map =
        LabelOften(labeler, scene.Update({0.003, 0.01, 0.01}), StandingAt(0, 0, 0, yaw));
    EXPECT_EQ(WrongLabels(scene, *map), "") << "yaw " << yaw;
    ASSERT_EQ(map->staircases.size(), 1u) << "yaw " << yaw;
    EXPECT_GT(map->staircases[0].direction_up_world.dot(Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0)),
              0.998);
  }
}

TEST(TerrainLabelerTest, FindsTheStaircaseUnderNoise) {
  const LabelScene scene = StairsUp();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    TerrainLabeler labeler = MakeLabeler();
    // A centimetre in place and height and two degrees: what a map from stereo has at two metres.
    const TerrainMapPtr map =
        LabelOften(labeler, scene.Update({0.008, 0.035, 0.025}, seed), StandingAt(5, 0));
    EXPECT_EQ(WrongLabels(scene, *map), "") << "seed " << seed;
    ASSERT_EQ(map->staircases.size(), 1u) << "seed " << seed;
    EXPECT_EQ(map->staircases[0].num_risers, 6) << "seed " << seed;
    EXPECT_NEAR(map->staircases[0].riser_m, 0.17, 0.008) << "seed " << seed;
    EXPECT_NEAR(map->staircases[0].tread_m, 0.28, 0.015) << "seed " << seed;
  }
}

/// Keeps the pieces of a scene for which `keep` holds.
template <typename Keep>
LabelScene Only(const LabelScene& scene, Keep keep) {
  LabelScene some;
  for (const KnownPiece& piece : scene.pieces)
    if (keep(piece)) some.Add(piece);
  return some;
}

TEST(TerrainLabelerTest, FindsRisersAndTwoTreadsFromBelow) {
  // From 0.45 m above the floor the treads above the second are hidden.
  const LabelScene scene = Only(StairsUp(), [](const KnownPiece& p) {
    return (p.label != kStairTread || p.step_index <= 2) && !(p.label == kWalkway && p.outline[0].z() > 0.5);
  });
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update({0.005, 0.02, 0.015}), StandingAt(5, 0));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].num_risers, 6);
  EXPECT_EQ(map->staircases[0].num_treads, 5);
}

TEST(TerrainLabelerTest, FindsTreadsAloneGoingDown) {
  const LabelScene scene = Only(StairsUp(), [](const KnownPiece& p) { return p.label != kStairRiser; });
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map =
      LabelOften(labeler, scene.Update({0.004, 0.015, 0.015}), StandingAt(9.5, 0, 1.02, kPi));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].num_risers, 6);
  EXPECT_EQ(map->staircases[0].num_treads, 5);
  EXPECT_GT(map->staircases[0].direction_up_world.x(), 0.99);
}

TEST(TerrainLabelerTest, KeepsTheIndicesWhenATreadIsMissing) {
  const LabelScene scene = Only(StairsUp(), [](const KnownPiece& p) { return p.step_index != 3; });
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update({0.004, 0.015, 0.01}), StandingAt(5, 0));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].num_risers, 6);
}

TEST(TerrainLabelerTest, GivesAllFragmentsOfATreadTheSameIndex) {
  LabelScene scene = Only(StairsUp(), [](const KnownPiece& p) { return p.label != kStairTread; });
  for (int k = 1; k <= 5; ++k) {
    for (const double y : {-0.36, 0.36}) {
      const double x = 7 + (k - 1) * 0.28;
      const double z = k * 0.17;
      scene.Add({{{x, y - 0.3, z}, {x + 0.28, y - 0.3, z}, {x + 0.28, y + 0.3, z}, {x, y + 0.3, z}},
                 {},
                 kStairTread,
                 k});
    }
  }
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update({0.004, 0.015, 0.01}), StandingAt(5, 0));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  EXPECT_EQ(map->staircases.size(), 1u);
}

TEST(TerrainLabelerTest, FindsOpenRisersAndNosing) {
  for (const bool open : {true, false}) {
    LabelScene scene = Corridor();
    KnownFlight flight;
    flight.foot = {7, 0, 0};
    flight.open_risers = open;
    flight.nosing_m = 0.03;
    scene.AddFlight(flight);
    scene.AddLevel(kWalkway, {9.9, 0, 1.02}, 3, 2);
    TerrainLabeler labeler = MakeLabeler();
    const TerrainMapPtr map = LabelOften(labeler, scene.Update({0.003, 0.01, 0.01}), StandingAt(5, 0));
    EXPECT_EQ(WrongLabels(scene, *map), "");
    ASSERT_EQ(map->staircases.size(), 1u);
    EXPECT_EQ(map->staircases[0].num_risers, 6);
  }
}

TEST(TerrainLabelerTest, FindsSpiralsThatTurnEitherWay) {
  for (const double turn : {0.35, -0.35}) {
    LabelScene scene;
    scene.AddLevel(kWalkway, {1.0, turn > 0 ? -1.5 : 1.5, 0}, 3, 3);
    scene.AddSpiral({0, 0, 0}, 0.3, 1.3, 9, 0.17, turn);
    TerrainLabeler labeler = MakeLabeler();
    const TerrainMapPtr map =
        LabelOften(labeler, scene.Update({0.003, 0.01, 0.01}),
                   StandingAt(1.0, turn > 0 ? -2 : 2, 0, turn > 0 ? kPi / 2 : -kPi / 2));
    EXPECT_EQ(WrongLabels(scene, *map), "");
    ASSERT_EQ(map->staircases.size(), 1u);
    EXPECT_EQ(map->staircases[0].num_risers, 9);
    EXPECT_NEAR(map->staircases[0].turn_per_step_rad, turn, 0.03);
    EXPECT_NEAR(map->staircases[0].riser_m, 0.17, 0.005);
  }
}

TEST(TerrainLabelerTest, FindsTreadsOfAWideSpiralAlthoughTheirOuterEndsAreDeep) {
  LabelScene scene;
  scene.AddLevel(kWalkway, {1.0, -1.5, 0}, 3, 3);
  scene.AddSpiral({0, 0, 0}, 0.3, 1.7, 8, 0.16, 0.43);
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map =
      LabelOften(labeler, scene.Update({0.003, 0.01, 0.01}), StandingAt(1.0, -2, 0, kPi / 2));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].num_risers, 8);
}

TEST(TerrainLabelerTest, FindsNoStairsInKerbBoxesAndRamp) {
  LabelScene scene;
  scene.AddLevel(kWalkway, {2, 0, 0}, 6, 3);
  scene.AddFace(kObstacle, {5, 1.5, 0}, {5, -1.5, 0}, 0.12);  // kerb face
  scene.AddLevel(kWalkway, {6, 0, 0.12}, 2, 3);               // pavement
  scene.AddBox({3, 1.0, 0}, 0.6, 0.4, 0.2);
  scene.AddBox({3.4, 1.0, 0}, 0.2, 0.4, 0.4);
  scene.AddBox({2.5, -1.0, 0}, 0.4, 0.4, 0.3, 0.5);
  scene.Add({{{5, -3, 0.0}, {7, -3, 0.5}, {7, -1.6, 0.5}, {5, -1.6, 0}}, {}, kRamp});
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update(), StandingAt(4, 0));
  EXPECT_EQ(WrongLabels(scene, *map), "");
  EXPECT_TRUE(map->staircases.empty());
}

TEST(TerrainLabelerTest, TakesThreeSurfacesThatHappenToStandInARowForNoStairs) {
  // Clutter beside the way: a rise, a run and a direction can always be chosen so that three faces obey.
  LabelScene scene;
  scene.AddLevel(kWalkway, {0, 0, 0}, 4, 2);
  for (int k = 0; k < 3; ++k) {
    const double x = 3.5 + 0.23 * k, bottom = 0.5 + 0.22 * k;
    scene.AddFace(kObstacle, {x, 0.4, bottom}, {x, -0.4, bottom}, 0.22);
  }
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_TRUE(LabelOften(labeler, scene.Update(), StandingAt(0, 0))->staircases.empty());
}

TEST(TerrainLabelerTest, FindsATwoStepFlightToAPlatformButNotTwoStackedBoxes) {
  LabelScene platform;
  platform.AddLevel(kWalkway, {2, 0, 0}, 4, 3);
  KnownFlight flight;
  flight.foot = {4, 0, 0};
  flight.num_risers = 2;
  flight.width_m = 2.0;
  platform.AddFlight(flight);
  platform.AddLevel(kWalkway, {5.28, 0, 0.34}, 2, 2);
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, platform.Update({0.003, 0.01, 0.01}), StandingAt(2, 0));
  EXPECT_EQ(WrongLabels(platform, *map), "");
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].num_risers, 2);

  LabelScene boxes;
  boxes.AddLevel(kWalkway, {2, 0, 0}, 6, 3);
  boxes.AddBox({3, 0, 0}, 0.7, 0.6, 0.17);
  boxes.AddBox({3.1, 0, 0.17}, 0.4, 0.6, 0.17);
  TerrainLabeler other = MakeLabeler();
  EXPECT_TRUE(LabelOften(other, boxes.Update(), StandingAt(1, 0))->staircases.empty());
}

TEST(TerrainLabelerTest, JudgesHeightsFromTheGroundAtTheFoot) {
  // A box on a landing one metre up is a box, and a wall that rises from down there is a wall.
  LabelScene scene = StairsUp();
  scene.AddBox({10.5, 0.6, 1.02}, 0.4, 0.4, 0.45, 0.2);
  scene.AddFace(kWall, {11.4, 1, 1.02}, {11.4, -1, 1.02}, 1.3);
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(5, 0))), "");
}

TEST(TerrainLabelerTest, JudgesSlopesByGravity) {
  // A world frame that leans by 6 deg: the floor is level all the same, and a ramp of 6 deg is one of 12.
  LabelScene scene;
  const double lean = 6.0 * kPi / 180.0;
  scene.AddLevel(kWalkway, {0, 0, 0}, 4, 4);
  const double rise = 2.0 * std::tan(12.0 * kPi / 180.0);
  scene.Add({{{2, -1, 0}, {4, -1, rise}, {4, 1, rise}, {2, 1, 0}}, {}, kRamp});
  const Eigen::Matrix3d R = Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY()).toRotationMatrix();
  LabelScene leaning = scene;
  for (KnownPiece& piece : leaning.pieces)
    for (Eigen::Vector3d& p : piece.outline) p = R * p;
  Gravity gravity = TestGravity();
  gravity.down_world = R * gravity.down_world;
  PoseEstimate pose = StandingAt(0, 0);
  pose.T_world_left = Eigen::Isometry3d(R) * pose.T_world_left;
  TerrainLabeler labeler = MakeLabeler();
  for (int frame = 0; frame < 5; ++frame) labeler.Label(leaning.Update(), pose, gravity);
  EXPECT_EQ(WrongLabels(scene, *labeler.map()), "");
}

TEST(TerrainLabelerTest, NeverCallsAnInclineARampInWhichStepsMayHide) {
  // Stairs seen from afar: a plane of 29 deg, its noise as high as a step.
  LabelScene scene;
  scene.AddLevel(kWalkway, {1, 0, 0}, 6, 2);
  scene.Add({{{4, -1, 0}, {6, -1, 1.1}, {6, 1, 1.1}, {4, 1, 0}}, {}, kRamp});
  PolygonUpdate update = scene.Update();
  auto far = std::make_shared<Polygon>(*update.changed[1]);
  far->rms_m = 0.024;
  far->noise_m = 0.026;
  update.changed[1] = far;
  TerrainLabeler labeler = MakeLabeler();
  for (int frame = 0; frame < 10; ++frame) {
    labeler.Label(update, StandingAt(0, 0), TestGravity());
    EXPECT_EQ(labeler.map()->regions[1]->label, kUnknown) << "frame " << frame;
  }
  // From near it is seen to be a plane, and is told a few frames later.
  auto near = std::make_shared<Polygon>(*far);
  near->rms_m = 0.002;
  near->noise_m = 0.004;
  update.changed[1] = near;
  EXPECT_EQ(LabelOften(labeler, update, StandingAt(2.5, 0))->regions[1]->label, kRamp);
  // Evidence against it is heard at once.
  update.changed[1] = far;
  EXPECT_EQ(labeler.Label(update, StandingAt(2.5, 0), TestGravity()).map->regions[1]->label, kUnknown);
}

TEST(TerrainLabelerTest, KnowsAWallThatLeavesTheViewFromABoxThatEndsInIt) {
  // Both faces were seen up to 0.6 m above the floor: the wall because the image ends there.
  LabelScene scene;
  scene.AddLevel(kWalkway, {2, 0, 0}, 4, 2);
  scene.AddFace(kWall, {1.0, 1, 0}, {1.6, 1, 0}, 0.62);
  scene.AddFace(kObstacle, {3.2, -0.2, 0}, {3.2, -0.7, 0}, 0.55);
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(-0.2, 0))), "");
}

TEST(TerrainLabelerTest, TakesAWallThatGrewForOneUntilItsTopIsSeenForSomeTime) {
  const auto scene_with = [](double height_m) {
    LabelScene scene;
    scene.AddLevel(kWalkway, {2, 0, 0}, 4, 2);
    scene.AddFace(kWall, {2, 0.4, 0}, {2, -0.4, 0}, height_m);
    return scene;
  };
  TerrainLabeler labeler = MakeLabeler();
  const LabelScene low = scene_with(0.62), high = scene_with(0.75);
  const auto label_of_face = [](const TerrainMapPtr& map) { return map->regions[1]->label; };
  // The image ends at its top, then, from farther away, above it.
  EXPECT_EQ(label_of_face(LabelOften(labeler, low.Update(), StandingAt(0.8, 0), 10)), kWall);
  EXPECT_EQ(label_of_face(LabelOften(labeler, high.Update(), StandingAt(-1.2, 0), 4)), kWall);
  EXPECT_EQ(label_of_face(LabelOften(labeler, high.Update(), StandingAt(-1.2, 0), 30)), kObstacle);
}

TEST(TerrainLabelerTest, KnowsTheWallsBesideAStepThatLiesInTheirPlane) {
  // One face: left and right a wall that leaves the view, between them what a platform stands on.
  LabelScene scene;
  scene.AddLevel(kWalkway, {0.6, 0, 0}, 2, 2);
  scene.AddLevel(kWalkway, {2.4, 0, 0.17}, 1.6, 0.7);
  KnownPiece face;
  for (const auto& [y, z] :
       {std::pair(1.0, 0.0), std::pair(-1.0, 0.0), std::pair(-1.0, 0.62), std::pair(-0.35, 0.62),
        std::pair(-0.35, 0.17), std::pair(0.35, 0.17), std::pair(0.35, 0.62), std::pair(1.0, 0.62)})
    face.outline.emplace_back(1.6, y, z);
  face.label = kWall;
  scene.Add(face);
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(0.4, 0))), "");
}

TEST(TerrainLabelerTest, CallsWhatCannotBeReachedLevelAndWhatFacesDownUnknown) {
  LabelScene scene = Corridor();
  scene.AddLevel(kLevel, {4, 0.8, 1.4}, 1.0, 0.4);  // a shelf
  KnownPiece ceiling{{{-1, -1, 2.6}, {-1, 1, 2.6}, {7, 1, 2.6}, {7, -1, 2.6}}, {}, kUnknown};
  scene.Add(ceiling);
  TerrainLabeler labeler = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(0, 0))), "");
}

TEST(TerrainLabelerTest, StartsFromTheGroundUnderTheRobotAlthoughItIsNeverSeen) {
  // Two floors 0.6 m apart in height: the robot can only be on the one at the height of its feet.
  LabelScene scene;
  scene.AddLevel(kWalkway, {2, 0, 0}, 2.6, 2);
  scene.AddLevel(kLevel, {4.5, 0, 1.6}, 2, 2);
  TerrainLabeler below = MakeLabeler();
  EXPECT_EQ(WrongLabels(scene, *LabelOften(below, scene.Update(), StandingAt(0, 0))), "");
  std::swap(scene.pieces[0].label, scene.pieces[1].label);
  TerrainLabeler above = MakeLabeler();
  const TerrainMapPtr map = LabelOften(above, scene.Update(), StandingAt(3.0, 0, 1.6));
  EXPECT_EQ(map->regions[1]->label, kWalkway);
  EXPECT_NE(map->regions[0]->label, kWalkway);
}

TEST(TerrainLabelerTest, ClimbsNoHigherThanTheRobotCan) {
  for (const double height : {0.15, 0.3}) {
    LabelScene scene;
    scene.AddLevel(kWalkway, {1.5, 0, 0}, 3, 2);
    scene.AddFace(kObstacle, {3, 1, 0}, {3, -1, 0}, height);
    scene.AddLevel(height < 0.2 ? kWalkway : kObstacle, {4, 0, height}, 2, 2);
    TerrainLabeler labeler = MakeLabeler();
    EXPECT_EQ(WrongLabels(scene, *LabelOften(labeler, scene.Update(), StandingAt(0, 0))), "") << height;
  }
}

TEST(TerrainLabelerTest, SharesUnchangedRegionsAndCountsRevisions) {
  const LabelScene scene = StairsUp();
  TerrainLabeler labeler = MakeLabeler();
  PolygonUpdate update = scene.Update();
  const TerrainMapPtr first = LabelOften(labeler, update, StandingAt(5, 0));
  const TerrainMapPtr second = labeler.Label(update, StandingAt(5.01, 0), TestGravity()).map;
  EXPECT_EQ(first->regions, second->regions);
  EXPECT_EQ(first->seq, second->seq);

  auto wall = std::make_shared<Polygon>(*update.changed[1]);
  ++wall->revision;
  wall->rms_m = 0.005;
  update.changed[1] = wall;
  const TerrainMapPtr third = labeler.Label(update, StandingAt(5.01, 0), TestGravity()).map;
  EXPECT_EQ(third->seq, second->seq + 1);
  EXPECT_EQ(third->regions[1]->revision, second->regions[1]->revision + 1);
  EXPECT_EQ(third->regions[0], second->regions[0]);
  EXPECT_EQ(labeler.map(), third);
}

TEST(TerrainLabelerTest, TellsNothingThatIsNotMuchWiderThanItsNoiseButTheStepsOfAStaircase) {
  const LabelScene scene = StairsUp();
  PolygonUpdate update = scene.Update();
  // Floor, walls and landing are wide enough even so; a riser of 0.17 m by 1.4 m alone would not be.
  for (PolygonPtr& polygon : update.changed) {
    auto noisy = std::make_shared<Polygon>(*polygon);
    noisy->noise_m = 0.05;
    polygon = std::move(noisy);
  }
  auto scrap = std::make_shared<Polygon>(*update.changed.back());
  scrap->id = update.changed.back()->id + 1;
  scrap->area_m2 = 0.2;
  for (Eigen::Vector3d& p : scrap->outline_world) p += Eigen::Vector3d(0, 8, 0);
  update.changed.push_back(scrap);
  std::erase(update.removed, scrap->id);
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, update, StandingAt(5, 0));
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].num_risers, 6);
  EXPECT_EQ(map->regions.size(), update.changed.size() - 1);
  EXPECT_LT(map->regions.back()->id, scrap->id);
}

TEST(TerrainLabelerTest, DoesNotFlickerWhenOneFrameIsWrong) {
  const LabelScene scene = Corridor();
  TerrainLabeler labeler = MakeLabeler();
  PolygonUpdate update = scene.Update();
  LabelOften(labeler, update, StandingAt(0, 0));
  PolygonUpdate wrong = update;
  auto tilted = std::make_shared<Polygon>(*update.changed[0]);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.5, 0, 1).normalized();
  tilted->plane_world = {normal, normal.dot(tilted->centroid_world)};
  for (Eigen::Vector3d& p : tilted->outline_world)
    p.z() = (tilted->plane_world.offset_m - normal.x() * p.x()) / normal.z();
  wrong.changed[0] = tilted;
  EXPECT_EQ(labeler.Label(wrong, StandingAt(0, 0), TestGravity()).map->regions[0]->label, kWalkway);
  EXPECT_EQ(labeler.Label(update, StandingAt(0, 0), TestGravity()).map->regions[0]->label, kWalkway);
}

TEST(TerrainLabelerTest, KeepsTheIdOfAStaircaseWhileMoreOfItAppears) {
  const LabelScene all = StairsUp();
  const PolygonUpdate complete = all.Update({0.003, 0.01, 0.01});
  TerrainLabeler labeler = MakeLabeler();
  std::int64_t id = 0;
  for (const int steps : {3, 4, 5, 6}) {
    PolygonUpdate some = complete;
    Remove(&some, [&](const PolygonPtr& p) {
      const KnownPiece& piece = all.pieces[static_cast<std::size_t>(p->id) - 1];
      return piece.step_index > steps ||
             (piece.label == kWalkway && p->centroid_world.z() > 0.5 && steps < 6);
    });
    const TerrainMapPtr map = LabelOften(labeler, some, StandingAt(5, 0));
    ASSERT_EQ(map->staircases.size(), 1u) << steps;
    if (id == 0) id = map->staircases[0].id;
    EXPECT_EQ(map->staircases[0].id, id) << steps;
    EXPECT_EQ(map->staircases[0].num_risers, steps);
  }
}

TEST(TerrainLabelerTest, SurvivesFramesWithoutTheStaircaseAndForgetsItWhenItIsGone) {
  const LabelScene scene = StairsUp();
  const PolygonUpdate update = scene.Update();
  TerrainLabeler labeler = MakeLabeler();
  LabelOften(labeler, update, StandingAt(5, 0));
  PolygonUpdate gone = update;
  Remove(&gone, [&](const PolygonPtr& p) {
    return scene.pieces[static_cast<std::size_t>(p->id) - 1].step_index > 0;
  });
  EXPECT_TRUE(LabelOften(labeler, gone, StandingAt(5, 0))->staircases.empty());
}

TEST(TerrainLabelerTest, TrustsNoLabelMoreThanHalfWhenGravityIsAssumed) {
  const LabelScene scene = StairsUp();
  Gravity gravity = TestGravity();
  gravity.source = GravitySource::kAssumed;
  TerrainLabeler labeler = MakeLabeler();
  for (int i = 0; i < 4; ++i) labeler.Label(scene.Update(), StandingAt(5, 0), gravity);
  for (const auto& region : labeler.map()->regions) EXPECT_LE(region->confidence, 0.5);
  for (const Staircase& s : labeler.map()->staircases) EXPECT_LE(s.confidence, 0.5);
}

TEST(TerrainLabelerTest, ProbabilitiesSumToOneAndStaircasesAgreeWithTheirRegions) {
  const LabelScene scene = StairsUp();
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update({0.003, 0.01, 0.01}), StandingAt(5, 0));
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_THAT(map->staircases[0].region_ids,
              ::testing::WhenSorted(::testing::Eq(map->staircases[0].region_ids)));
  for (const auto& region : map->regions) {
    EXPECT_GT(region->confidence, 0.0);
    EXPECT_LE(region->confidence, 1.0);
    const bool listed = std::ranges::binary_search(map->staircases[0].region_ids, region->id);
    EXPECT_EQ(region->staircase_id.has_value(), listed);
    EXPECT_EQ(region->step_index.has_value(), listed);
  }
}

TEST(TerrainLabelerTest, SaysWhatLiesBeyondTheEdgesOfAPlatform) {
  LabelScene scene;
  scene.AddLevel(kWalkway, {0, 0, 0}, 4, 4);
  scene.AddFace(kObstacle, {2, 2, 0}, {2, -2, 0}, 0.15);
  scene.AddLevel(kWalkway, {3, 0, 0.15}, 2, 4);
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, scene.Update(), StandingAt(0, 0));
  // Outlines run from the corner at -x -y: the second edge is the one at +x, the fourth the one at -x.
  ASSERT_EQ(map->regions[0]->edges.size(), 4u);
  EXPECT_EQ(map->regions[0]->edges[1].kind, EdgeKind::kRise);
  EXPECT_EQ(map->regions[0]->edges[3].kind, EdgeKind::kLimitOfView);
  EXPECT_EQ(map->regions[2]->edges[3].kind, EdgeKind::kDrop);
}

TEST(TerrainLabelerTest, StandsAnEmptyMap) {
  TerrainLabeler labeler = MakeLabeler();
  const TerrainMapPtr map = LabelOften(labeler, PolygonUpdate{}, StandingAt(0, 0));
  EXPECT_TRUE(map->regions.empty());
  EXPECT_EQ(map->seq, 0);
}

TEST(LabelingConfigTest, DefaultsCanBeUsedAndNonsenseIsNamed) {
  EXPECT_TRUE(LabelingConfig{}.Problems().empty());
  EXPECT_TRUE(StaircaseConfig{}.Problems().empty());
  EXPECT_TRUE(RobotConfig{}.Problems().empty());
  LabelingConfig labeling;
  labeling.min_upright_deg = 20.0;
  labeling.frames_to_change_label = 0;
  EXPECT_EQ(labeling.Problems().size(), 2u);
  StaircaseConfig staircases;
  staircases.min_riser_m = 0.5;
  EXPECT_EQ(staircases.Problems().size(), 1u);
  RobotConfig robot;
  robot.max_ramp_slope_deg = 5.0;
  EXPECT_EQ(robot.Problems().size(), 1u);
}

}  // namespace
}  // namespace terrace
