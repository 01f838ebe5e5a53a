// SPDX-License-Identifier: BSD-3-Clause
// Floors of whole centimetres, so that footholds can be counted by hand: of a square metre 94 x 94 lie 3 cm
// inside the outline.
#include "evaluation/feet_evaluation.h"

#include <gtest/gtest.h>

#include "evaluation/feet_picture.h"
#include "test/evaluation/exact.h"
#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

constexpr double kFootCell_m2 = 1e-4;
const Eigen::Vector3d kAlongX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kAlongY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kUpwards = Eigen::Vector3d::UnitZ();

/// A square metre of floor in the air.
TrueScene Platform(const std::string& label = "walkway") {
  TrueScene scene;
  scene.polygons.push_back(Rectangle(1, label, {0, 0, 0}, kAlongX, kAlongY, 25, 25));
  return scene;
}

/// All of the walkable truth, as if it had been well seen.
CellsOfPolygons AllWellSeen(const TrueScene& scene) {
  CellsOfPolygons cells;
  for (const TruePolygon& polygon : scene.polygons) {
    if (IsWalkable(polygon.label)) cells[polygon.id] = polygon.observed;
  }
  return cells;
}

/// The only region of the map with another extent along x, and lifted.
TerrainMap Changed(const TerrainMap& map, double to_x_m, double lift_m = 0.0) {
  TerrainMap changed = map;
  TerrainRegion region = *map.regions[0];
  region.outline_world = {{0, 0, lift_m}, {to_x_m, 0, lift_m}, {to_x_m, 1, lift_m}, {0, 1, lift_m}};
  region.plane_world.offset_m = lift_m;
  changed.regions[0] = std::make_shared<const TerrainRegion>(region);
  return changed;
}

FeetEvaluation EvaluateOn(const TerrainMap& map, const TrueScene& truth) {
  return EvaluateFeet(map, truth, AllWellSeen(truth), Eigen::Isometry3d::Identity());
}

TEST(FeetEvaluationTest, GivesPerfectMarksToTheTruth) {
  const TrueScene truth = Platform();
  const FeetEvaluation feet = EvaluateOn(MapOf(truth), truth);
  EXPECT_NEAR(feet.foothold_m2, 94 * 94 * kFootCell_m2, kExact);
  EXPECT_NEAR(feet.well_seen_m2, 94 * 94 * kFootCell_m2, kExact);
  EXPECT_NEAR(*feet.unsupported_pct(), 0.0, kExact);
  EXPECT_NEAR(*feet.offered_pct(), 100.0, kExact);
  EXPECT_NEAR(*feet.drop_over_p100_m, 0.0, kExact);
  EXPECT_NEAR(feet.edges.p95_m, 0.0, kExact);
  EXPECT_EQ(feet.drops.size(), 200u);  // 4 m of edge
}

TEST(FeetEvaluationTest, CountsFootholdsBeyondATrueEdgeAsUnsupported) {
  const TrueScene truth = Platform();
  const FeetEvaluation feet = EvaluateOn(Changed(MapOf(truth), 1.10), truth);
  EXPECT_NEAR(feet.foothold_m2, 104 * 94 * kFootCell_m2, kExact);
  // Footholds reach to 1.07 m, discs of 2 cm about those up to 1.02 m touch the floor: five columns do not.
  EXPECT_NEAR(feet.unsupported_m2, 5 * 94 * kFootCell_m2, kExact);
  EXPECT_NEAR(*feet.unsupported_pct(), 100.0 * 5 / 104, 1e-6);
  EXPECT_NEAR(feet.unsupported_drop_m2, 5 * 94 * kFootCell_m2, kExact);
  EXPECT_EQ(feet.unsupported_tread_m2, 0.0);
  constexpr double kStep_m = 1e-3;  // in which the reach is found
  EXPECT_NEAR(*feet.drop_over_p100_m, 0.10, 1.5 * kStep_m);
  EXPECT_NEAR(*feet.offered_pct(), 100.0, kExact);
}

TEST(FeetEvaluationTest, TakesTheGroundBelowADropForNoReachPastIt) {
  TrueScene truth = Platform();
  truth.polygons.push_back(Rectangle(2, "walkway", {1, 0, -0.051}, kAlongX, kAlongY, 25, 25));
  EXPECT_NEAR(*EvaluateOn(MapOf(truth), truth).drop_over_p100_m, 0.0, kExact);
}

TEST(FeetEvaluationTest, CountsWhatAShortRegionDoesNotOffer) {
  const TrueScene truth = Platform("stair_tread");
  const FeetEvaluation feet = EvaluateOn(Changed(MapOf(truth), 0.95), truth);
  EXPECT_NEAR(*feet.offered_pct(), 100.0 * 89 / 94, 1e-6);
  ASSERT_EQ(feet.treads.size(), 1u);
  EXPECT_NEAR(feet.treads[0].offered_pct(), 100.0 * 89 / 94, 1e-6);
  EXPECT_NEAR(*feet.tread_offered_min_pct(), 100.0 * 89 / 94, 1e-6);
  EXPECT_NEAR(*feet.unsupported_pct(), 0.0, kExact);
}

TEST(FeetEvaluationTest, MeasuresTheEdgesOfWhatWasWellSeen) {
  const TrueScene truth = Platform();
  // A quarter of the edge is 1 cm short; beside the corners another edge is nearer.
  const EdgeFigures edges = EvaluateOn(Changed(MapOf(truth), 0.99), truth).edges;
  EXPECT_EQ(edges.count, 200);
  EXPECT_NEAR(edges.median_m, 0.0, kExact);
  EXPECT_NEAR(edges.p95_m, 0.01, kExact);
  EXPECT_NEAR(edges.bias_m, -0.01 / 4, 1e-4);
  EXPECT_EQ(edges.missed_share, 0.0);
}

TEST(FeetEvaluationTest, HoldsAFootThatIsTwoCentimetresOffInHeightButNotThree) {
  const TrueScene truth = Platform();
  const FeetEvaluation two = EvaluateOn(Changed(MapOf(truth), 1.0, 0.02), truth);
  EXPECT_NEAR(*two.unsupported_pct(), 0.0, kExact);
  EXPECT_NEAR(*two.offered_pct(), 100.0, kExact);
  const FeetEvaluation three = EvaluateOn(Changed(MapOf(truth), 1.0, -0.03), truth);
  EXPECT_NEAR(*three.unsupported_pct(), 100.0, 1e-6);
  EXPECT_NEAR(*three.offered_pct(), 0.0, kExact);
}

TEST(FeetEvaluationTest, StandsOnAnythingThatIsNotUprightWhateverItsLabel) {
  TrueScene truth = Platform();
  truth.polygons.push_back(Rectangle(2, "other", {1, 0, 0}, kAlongX, kAlongY, 25, 25));
  EXPECT_NEAR(*EvaluateOn(Changed(MapOf(Platform()), 1.5), truth).unsupported_pct(), 0.0, kExact);
  truth.polygons[1] = Rectangle(2, "wall", {1, 0, -0.5}, kUpwards, kAlongY, 25, 25);
  EXPECT_GT(*EvaluateOn(Changed(MapOf(Platform()), 1.5), truth).unsupported_pct(), 20.0);
}

TEST(FeetEvaluationTest, OffersNothingThatIsPredictedOrNotWalkable) {
  const TrueScene truth = Platform();
  const TerrainMap predicted =
      WithRegion(MapOf(truth), 1, [](TerrainRegion& region) { region.source = RegionSource::kPredicted; });
  const TerrainMap obstacle =
      WithRegion(MapOf(truth), 1, [](TerrainRegion& region) { region.label = TerrainLabel::kObstacle; });
  for (const TerrainMap& map : {predicted, obstacle}) {
    const FeetEvaluation feet = EvaluateOn(map, truth);
    EXPECT_FALSE(feet.unsupported_pct());
    EXPECT_EQ(*feet.offered_pct(), 0.0);
  }
  // What is only predicted covers no edge either, an obstacle does.
  EXPECT_NEAR(EvaluateOn(predicted, truth).edges.missed_share, 1.0, kExact);
  EXPECT_NEAR(EvaluateOn(obstacle, truth).edges.missed_share, 0.0, kExact);
}

TEST(FeetEvaluationTest, AsksOnlyForWhatWasWellSeen) {
  const TrueScene truth = Platform();
  const FeetEvaluation feet = EvaluateFeet(MapOf(truth), truth, {}, Eigen::Isometry3d::Identity());
  EXPECT_FALSE(feet.offered_pct());
  EXPECT_FALSE(feet.tread_offered_pct());
  EXPECT_NEAR(*feet.unsupported_pct(), 0.0, kExact);
}

TEST(FeetEvaluationTest, PaintsWhatNothingCarriesRed) {
  const TrueScene truth = Platform();
  const ColourImage picture = PictureOfFeet(EvaluateOn(Changed(MapOf(truth), 1.10), truth));
  int red = 0, green = 0;
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      const std::uint8_t* p = picture.Pixel(u, v);
      red += p[0] > 200 && p[1] < 100;
      green += p[1] > 180 && p[0] < 150;
    }
  }
  EXPECT_EQ(red, 5 * 94);
  EXPECT_EQ(green, 99 * 94);
  EXPECT_TRUE(PictureOfFeet({}).data.empty());
}

}  // namespace
}  // namespace terrace
