// SPDX-License-Identifier: BSD-3-Clause
// The evaluator gives perfect marks to the truth, and the right ones to truth spoilt by known amounts. The
// expected figures are worked out by hand from the cells that small_world.h counts.
#include "evaluation/map_evaluation.h"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "test/evaluation/exact.h"
#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

constexpr double kCell_m2 = 0.0016;

MapEvaluation Evaluate(const TerrainMap& map, const TrueScene& truth,
                       const MapEvaluationOptions& options = {}) {
  return EvaluateMap(map, truth, Eigen::Isometry3d::Identity(), options);
}

const PolygonEvaluation& PolygonOf(const MapEvaluation& evaluation, int id) {
  for (const PolygonEvaluation& polygon : evaluation.polygons) {
    if (polygon.id == id) return polygon;
  }
  throw std::runtime_error("no such polygon");
}

void ExpectPerfect(const MapEvaluation& evaluation) {
  EXPECT_NEAR(evaluation.coverage, 1.0, kExact);
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.support_plane_rms_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.plane_p95_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.normal_p95_deg, 0.0, 1e-5);
  EXPECT_NEAR(evaluation.edges.p95_m, 0.0, kExact);
  EXPECT_GT(evaluation.edges.count, 100);
  EXPECT_NEAR(evaluation.over_segmentation, 1.0, kExact);
  EXPECT_NEAR(evaluation.under_segmentation, 1.0, kExact);
  EXPECT_NEAR(evaluation.label_accuracy, 1.0, kExact);
  for (const auto& [name, label] : evaluation.labels) EXPECT_NEAR(label.iou(), 1.0, kExact) << name;
}

TEST(MapEvaluationTest, GivesPerfectMarksToTheTruth) {
  const TrueScene truth = SmallWorld();
  const MapEvaluation evaluation = Evaluate(MapOf(truth), truth);
  ExpectPerfect(evaluation);
  EXPECT_EQ(evaluation.labels.size(), 5u);
  EXPECT_NEAR(evaluation.true_m2, kSmallWorldCells * kCell_m2, kExact);
  EXPECT_NEAR(evaluation.result_m2, kSmallWorldCells * kCell_m2, kExact);
}

TEST(MapEvaluationTest, GivesPerfectMarksInWhateverWorldTheResultWasMade) {
  const TrueScene truth = SmallWorld();
  Eigen::Isometry3d T_result_true = Eigen::Isometry3d::Identity();
  T_result_true.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, -0.2, 1.0).normalized()).toRotationMatrix();
  T_result_true.translation() = Eigen::Vector3d(3, -5, 0.4);
  const TerrainMap map = Transformed(T_result_true, MapOf(truth));
  // Rings turned by an odd angle: which cells a region fills differs by rounding at its edges, not more.
  const MapEvaluation evaluation = EvaluateMap(map, truth, T_result_true.inverse());
  EXPECT_NEAR(evaluation.coverage, 1.0, kExact);
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.plane_p95_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.edges.p95_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.mean_iou(), 1.0, kExact);
}

TEST(MapEvaluationTest, MeasuresAFloorLiftedByTwoCentimetres) {
  const TrueScene truth = SmallWorld();
  const TerrainMap map = WithRegion(MapOf(truth), 1, [](TerrainRegion& floor) {
    floor.plane_world.offset_m += 0.02;
    for (Eigen::Vector3d& p : floor.outline_world) p.z() += 0.02;
  });
  const MapEvaluation evaluation = Evaluate(map, truth);
  // 5000 of the 7650 support cells are 2 cm off: rms = 2 cm * sqrt(5000 / 7650) = 1.61690 cm.
  EXPECT_NEAR(evaluation.support_plane_rms_m, 0.0161690, 1e-7);
  // Of all 13350: 2 cm * sqrt(5000 / 13350) = 1.22398 cm.
  EXPECT_NEAR(evaluation.plane_rms_m, 0.0122398, 1e-7);
  EXPECT_NEAR(evaluation.plane_p95_m, 0.02, kExact);
  EXPECT_NEAR(PolygonOf(evaluation, 1).plane_bias_m, 0.02, kExact);
  EXPECT_NEAR(PolygonOf(evaluation, 1).plane_rms_m, 0.02, kExact);
  // Still within 5 cm, so nothing else changes.
  EXPECT_NEAR(evaluation.coverage, 1.0, kExact);
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("walkway").iou(), 1.0, kExact);
}

TEST(MapEvaluationTest, MissesAFloorLiftedBySixAndCallsOneAtEightCentimetresAGhost) {
  const TrueScene truth = SmallWorld();
  const TerrainMap six = WithRegion(MapOf(truth), 1, [](TerrainRegion& floor) {
    floor.plane_world.offset_m += 0.06;
    for (Eigen::Vector3d& p : floor.outline_world) p.z() += 0.06;
  });
  // Beyond the 5 cm of coverage, but within the 7.5 cm of ghosts and of false labels.
  MapEvaluation evaluation = Evaluate(six, truth);
  EXPECT_NEAR(evaluation.coverage, 8350.0 / 13350.0, kExact);
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("walkway").iou(), 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("walkway").false_m2, 0.0, kExact);

  const TerrainMap eight = WithRegion(MapOf(truth), 1, [](TerrainRegion& floor) {
    floor.plane_world.offset_m += 0.08;
    for (Eigen::Vector3d& p : floor.outline_world) p.z() += 0.08;
  });
  evaluation = Evaluate(eight, truth);
  // All of it but what lies within 7.5 cm of upright faces: the last two of 50 rows, at y = 1.94 and 1.98 m,
  // before the wall at y = 2 (200 cells), and of the last two of 100 columns, at x = 3.94 and 3.98 m, the 35
  // cells before the first riser at x = 4 (70 cells): 5000 - 270 = 4730.
  EXPECT_NEAR(evaluation.ghost_area, 4730.0 / 13350.0, kExact);
  EXPECT_NEAR(evaluation.confusion_m2.at("ghost").at("walkway"), 4730 * kCell_m2, kExact);
  // Beside the wall it is still no walkway: every cell is false.
  EXPECT_NEAR(evaluation.labels.at("walkway").false_m2, 5000 * kCell_m2, kExact);
}

TEST(MapEvaluationTest, MissesOneTreadOfTen) {
  const TrueScene truth = SmallWorld();
  const MapEvaluation evaluation = Evaluate(WithRegion(MapOf(truth), 24, nullptr), truth);
  EXPECT_NEAR(evaluation.labels.at("stair_tread").iou(), 0.9, kExact);
  EXPECT_NEAR(evaluation.labels.at("stair_riser").iou(), 1.0, kExact);
  EXPECT_NEAR(evaluation.coverage, (13350.0 - 245.0) / 13350.0, kExact);
  EXPECT_NEAR(evaluation.confusion_m2.at("stair_tread").at("missed"), 245 * kCell_m2, kExact);
  EXPECT_NEAR(PolygonOf(evaluation, 24).coverage(), 0.0, kExact);
}

TEST(MapEvaluationTest, PunishesASwappedLabelOnBothSides) {
  const TrueScene truth = SmallWorld();
  const TerrainMap map =
      WithRegion(MapOf(truth), 3, [](TerrainRegion& chest) { chest.label = TerrainLabel::kWalkway; });
  const MapEvaluation evaluation = Evaluate(map, truth);
  // The chest is all there is of obstacle; its 200 cells are false walkway beside 5000 true ones.
  EXPECT_NEAR(evaluation.labels.at("obstacle").iou(), 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("walkway").iou(), 5000.0 / 5200.0, kExact);
  EXPECT_NEAR(evaluation.confusion_m2.at("obstacle").at("walkway"), 200 * kCell_m2, kExact);
  EXPECT_NEAR(evaluation.label_accuracy, 13150.0 / 13350.0, kExact);
  EXPECT_NEAR(evaluation.coverage, 1.0, kExact);
}

TEST(MapEvaluationTest, TellsALevelFromAnObstacle) {
  TrueScene truth = SmallWorld();
  const TerrainMap map =
      WithRegion(MapOf(truth), 3, [](TerrainRegion& chest) { chest.label = TerrainLabel::kLevel; });
  EXPECT_NEAR(Evaluate(map, truth).confusion_m2.at("obstacle").at("level"), 200 * kCell_m2, kExact);
  truth.polygons[2].label = "level";
  ExpectPerfect(Evaluate(map, truth));
}

TEST(MapEvaluationTest, TakesWhatIsPredictedForNothing) {
  const TrueScene truth = SmallWorld();
  const TerrainMap map = WithRegion(MapOf(truth), 24, [](TerrainRegion& tread) { tread.source = RegionSource::kPredicted; });
  const MapEvaluation evaluation = Evaluate(map, truth);
  EXPECT_NEAR(evaluation.labels.at("stair_tread").iou(), 0.9, kExact);
  EXPECT_NEAR(evaluation.result_m2, (kSmallWorldCells - 245) * kCell_m2, kExact);
}

TEST(MapEvaluationTest, CountsARegionInMidAirAsGhost) {
  const TrueScene truth = SmallWorld();
  TerrainMap map = MapOf(truth);
  TrueScene phantom;
  phantom.polygons.push_back(
      Rectangle(99, "obstacle", {1, 0.5, 1.2}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 25, 10));
  map.regions.push_back(MapOf(phantom).regions.front());
  const MapEvaluation evaluation = Evaluate(map, truth);
  EXPECT_NEAR(evaluation.ghost_area, 250.0 / 13600.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("obstacle").iou(), 200.0 / 450.0, kExact);
  EXPECT_NEAR(evaluation.coverage, 1.0, kExact);
}

TEST(MapEvaluationTest, NeitherAsksForNorPunishesOtherAndDetail) {
  TrueScene truth = SmallWorld();
  const TerrainMap map = MapOf(truth);  // everything found
  truth.polygons[1].label = "other";    // the wall
  truth.polygons[2].detail = true;      // the chest
  const MapEvaluation evaluation = Evaluate(map, truth);
  ExpectPerfect(Evaluate(WithRegion(WithRegion(map, 2, nullptr), 3, nullptr), truth));
  EXPECT_NEAR(evaluation.true_m2, (13350 - 5000 - 200) * kCell_m2, kExact);
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("wall").false_m2, 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("obstacle").false_m2, 0.0, kExact);
  // Named, they are asked for.
  MapEvaluationOptions options;
  options.include_other = options.include_detail = true;
  EXPECT_NEAR(Evaluate(map, truth, options).true_m2, 13350 * kCell_m2, kExact);
}

TEST(MapEvaluationTest, CountsOnlyCellsThatWereSeen) {
  TrueScene truth = SmallWorld();
  // The far half of the floor was never seen and is not in the map: nothing is missed.
  for (std::size_t i = 2500; i < 5000; ++i) truth.polygons[0].observed.seen[i] = 0;
  const TerrainMap map = WithRegion(MapOf(truth), 1, [](TerrainRegion& floor) {
    for (Eigen::Vector3d& p : floor.outline_world) p.x() = std::min(p.x(), 2.0);
  });
  const MapEvaluation evaluation = Evaluate(map, truth);
  ExpectPerfect(evaluation);
  EXPECT_NEAR(evaluation.true_m2, (13350 - 2500) * kCell_m2, kExact);
}

TEST(MapEvaluationTest, TakesTheNearestOfTwoRegionsOverACell) {
  const TrueScene truth = SmallWorld();
  TerrainMap map = MapOf(truth);
  TrueScene above;
  above.polygons.push_back(
      Rectangle(99, "obstacle", {0, 0, 0.03}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 100, 50));
  map.regions.insert(map.regions.begin(), MapOf(above).regions.front());
  const MapEvaluation evaluation = Evaluate(map, truth);
  EXPECT_NEAR(evaluation.support_plane_rms_m, 0.0, kExact);
  // True floor lies under it within 7.5 cm, so it is no ghost; but it is no obstacle either.
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("obstacle").iou(), 200.0 / 5200.0, kExact);
  EXPECT_NEAR(evaluation.labels.at("walkway").iou(), 1.0, kExact);
}

TEST(MapEvaluationTest, AsksForTheAngleOfCoverageButNotForTheSideOfTheNormal) {
  const TrueScene truth = SmallWorld();
  const auto tilted = [&](double angle_rad) {
    TerrainMap tilt = WithRegion(MapOf(truth), 3, nullptr);
    TrueScene chest;
    // Turned about its middle line, so that all of the 0.4 m stays within 5 cm; and seen from below.
    const Eigen::Vector3d y(0, std::cos(angle_rad), std::sin(angle_rad));
    const Eigen::Vector3d middle(1, 0.7, 0.5);
    chest.polygons.push_back(
        Rectangle(3, "obstacle", middle + 0.2 * y, Eigen::Vector3d::UnitX(), -y, 20, 10));
    tilt.regions.push_back(MapOf(chest).regions.front());
    return Evaluate(tilt, truth);
  };
  // At 12 deg the outermost cells, 0.18 m from the middle, are 0.18 * sin = 3.7 cm off.
  EXPECT_NEAR(tilted(12 * EIGEN_PI / 180).coverage, 1.0, kExact);
  EXPECT_NEAR(PolygonOf(tilted(12 * EIGEN_PI / 180), 3).normal_deg, 12.0, 1e-6);
  EXPECT_NEAR(tilted(16 * EIGEN_PI / 180).coverage, 13150.0 / 13350.0, kExact);
}

TEST(MapEvaluationTest, MeasuresHowFarRegionsReachBeyondTrueEdges) {
  TrueScene truth;
  truth.polygons.push_back(
      Rectangle(1, "walkway", {0, 0, 0}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 100, 50));
  const auto grown = [&](double by_m) {
    TerrainMap map = MapOf(truth);
    TerrainRegion region = *map.regions[0];
    region.outline_world = {
        {-by_m, -by_m, 0}, {4 + by_m, -by_m, 0}, {4 + by_m, 2 + by_m, 0}, {-by_m, 2 + by_m, 0}};
    map.regions[0] = std::make_shared<const TerrainRegion>(region);
    return Evaluate(map, truth);
  };
  EXPECT_NEAR(grown(0.03).edges.median_m, 0.03, kExact);
  EXPECT_NEAR(grown(0.03).edges.bias_m, 0.03, kExact);
  EXPECT_NEAR(grown(-0.01).edges.median_m, 0.01, kExact);
  EXPECT_NEAR(grown(-0.01).edges.bias_m, -0.01, kExact);
  // 12 m of edge, a sample every 2 cm.
  EXPECT_EQ(grown(0.03).edges.count, 600);
}

TEST(MapEvaluationTest, CountsAnEdgeThatNothingCoversAsTwentyCentimetresOff) {
  TrueScene truth;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  truth.polygons.push_back(Rectangle(1, "walkway", {0, 0, 0}, x, y, 50, 50));
  truth.polygons.push_back(Rectangle(2, "walkway", {0, 0, 1}, x, y, 25, 25));
  // The lower one is found exactly, the upper one, with half the edge, not at all.
  const MapEvaluation evaluation = Evaluate(WithRegion(MapOf(truth), 2, nullptr), truth);
  EXPECT_EQ(evaluation.edges.count, 600);
  EXPECT_NEAR(evaluation.edges.median_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.edges.p95_m, 0.2, kExact);
  EXPECT_NEAR(evaluation.edges.covered_p95_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.edges.missed_share, 1.0 / 3.0, kExact);
  EXPECT_NEAR(evaluation.edges.bias_m, 0.0, kExact);
}

TEST(MapEvaluationTest, CountsPiecesOfOnePolygonAndPolygonsUnderOneRegion) {
  TrueScene truth;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  truth.polygons.push_back(Rectangle(1, "walkway", {0, 0, 0}, x, y, 50, 50));
  truth.polygons.push_back(Rectangle(2, "ramp", {2, 0, 0}, x, y, 50, 50));
  TrueScene whole;
  whole.polygons.push_back(Rectangle(7, "walkway", {0, 0, 0}, x, y, 100, 50));
  MapEvaluation evaluation = Evaluate(MapOf(whole), truth);
  EXPECT_NEAR(evaluation.under_segmentation, 2.0, kExact);
  EXPECT_NEAR(evaluation.over_segmentation, 1.0, kExact);
  // Two halves of the whole seen from the truth of the whole.
  evaluation = Evaluate(MapOf(truth), whole);
  EXPECT_NEAR(evaluation.under_segmentation, 1.0, kExact);
  EXPECT_NEAR(evaluation.over_segmentation, 2.0, kExact);
}

TEST(MapEvaluationTest, RefusesARegionTooLargeToBeTrue) {
  const TrueScene truth = SmallWorld();
  const TerrainMap map = WithRegion(MapOf(truth), 1, [](TerrainRegion& floor) {
    for (Eigen::Vector3d& p : floor.outline_world) p *= 1e6;
  });
  EXPECT_THROW(Evaluate(map, truth), std::runtime_error);
}

TEST(MapEvaluationTest, GivesAnEmptyMapNothing) {
  const MapEvaluation evaluation = Evaluate({}, SmallWorld());
  EXPECT_EQ(evaluation.coverage, 0.0);
  EXPECT_EQ(evaluation.ghost_area, 0.0);
  EXPECT_EQ(evaluation.mean_iou(), 0.0);
}

TEST(MapEvaluationTest, GivesPerfectMarksToTheTruthOfARenderedSequence) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA does not name the folder with the recordings";
  const TrueScene truth = LoadTrueScene(std::filesystem::path(data) / "corridor_stairs");
  const MapEvaluation evaluation = Evaluate(MapOf(truth), truth);
  EXPECT_NEAR(evaluation.coverage, 1.0, kExact);
  EXPECT_NEAR(evaluation.ghost_area, 0.0, kExact);
  EXPECT_NEAR(evaluation.support_plane_rms_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.mean_iou(), 1.0, kExact);
  // `visible.observed_area` of ground_truth.json for floor, riser 1 and landing.
  EXPECT_NEAR(PolygonOf(evaluation, 1).seen_m2, 7.7824, 1e-6);
  EXPECT_NEAR(PolygonOf(evaluation, 12).seen_m2, 0.2240, 1e-6);
  EXPECT_NEAR(PolygonOf(evaluation, 23).seen_m2, 6.4688, 1e-6);
}

}  // namespace
}  // namespace terrace
