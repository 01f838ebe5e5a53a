// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_finder.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "label_scene.h"
#include "labeling/flight_frame.h"
#include "labeling/step_elements.h"
#include "labeling/stride.h"

namespace terrace {
namespace {

constexpr double kRiseDown = 0.11;
constexpr double kRunDown = 0.28;
constexpr double kEdgeX = 3.0;  ///< where the upper floor ends

std::vector<RegionShapePtr> ShapesOf(const std::vector<PolygonPtr>& polygons) {
  std::vector<RegionShapePtr> shapes;
  for (const PolygonPtr& polygon : polygons)
    shapes.push_back(MakeRegionShape(polygon, Eigen::Matrix3d::Identity(), {0.52, 1.13, 0.5}));
  return shapes;
}

/// From 0.8 m before the edge, half a metre above the upper floor.
Sight FromAbove() {
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(kEdgeX - 0.8, 0.0, 0.5);
  return sight;
}

/// Upper floor, lower floor and between them three strips of one incline, as wide as what is seen of the
/// treads over the edges of the steps above, with points that leave the plane by `rms_m`.
/// @param hidden_m  of each tread
std::vector<RegionShapePtr> InclineInStrips(double rms_m, double hidden_m = 0.15) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 2.0 * (kEdgeX - 1), 1.6);
  scene.AddLevel(TerrainLabel::kWalkway, {5.7, 0, -4 * kRiseDown}, 3, 1.6);
  const double slope = kRiseDown / kRunDown;
  for (int k = 1; k <= 3; ++k) {
    const double front = kEdgeX + k * kRunDown, back = front - kRunDown + hidden_m;
    const double middle = 0.5 * (front + back);
    const auto z = [&](double x) { return -k * kRiseDown - slope * (x - middle); };
    scene.Add({{{back, -0.8, z(back)}, {front, -0.8, z(front)}, {front, 0.8, z(front)}, {back, 0.8, z(back)}},
               {},
               TerrainLabel::kUnknown});
  }
  std::vector<PolygonPtr> polygons = scene.Update().changed;
  for (std::size_t i = 2; i < polygons.size(); ++i) {
    auto strip = std::make_shared<Polygon>(*polygons[i]);
    strip->noise_m = 0.003;
    strip->rms_m = rms_m;
    polygons[i] = strip;
  }
  return ShapesOf(polygons);
}

TEST(StaircaseFinderTest, FindsAFlightDownInStripsOfItsTreadsThatMergedIntoOneIncline) {
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(InclineInStrips(0.013), {}, FromAbove(), true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 4);
  EXPECT_EQ(found[0].num_treads, 3);
  EXPECT_NEAR(found[0].model.rise_m, kRiseDown, 0.003);
  EXPECT_NEAR(found[0].model.run_m, kRunDown, 0.01);
  EXPECT_LT(found[0].model.UpAt(1.0).x(), -0.99);
  EXPECT_TRUE(std::all_of(found[0].members.begin(), found[0].members.end(),
                          [](const StepMember& m) { return m.only_evidence && !m.riser; }));
}

TEST(StaircaseFinderTest, FindsAFlightInStripsOfAnInclineThatAreLowerThanAStep) {
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(InclineInStrips(0.013, 0.18), {}, FromAbove(), true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 4);
  EXPECT_NEAR(found[0].model.rise_m, kRiseDown, 0.003);
}

TEST(StaircaseFinderTest, FindsNoFlightInARampOfWhichStripsAreHidden) {
  const StaircaseFinder finder{StaircaseConfig{}};
  EXPECT_TRUE(finder.Find(InclineInStrips(0.002), {}, FromAbove(), true).empty());
  EXPECT_TRUE(finder.Find(InclineInStrips(0.002, 0.18), {}, FromAbove(), true).empty());
}

TEST(StaircaseFinderTest, MeasuresTheRiseByTheTopsOfFacesWhoseFeetAreHidden) {
  constexpr double kRise = 0.17, kRun = 0.28;
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
  for (int k = 1; k <= 6; ++k) {
    // From a low eye the more of a face is hidden the higher it is.
    const double x = 3.0 + (k - 1) * kRun, hidden = 0.012 * k, foot = (k - 1) * kRise + hidden;
    scene.AddFace(TerrainLabel::kStairRiser, {x, 0.8, foot}, {x, -0.8, foot}, kRise - hidden, k);
  }
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.0, 0.0, 0.3);
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(ShapesOf(scene.Update().changed), {}, sight, true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].model.rise_m, kRise, 0.001);
  EXPECT_NEAR(found[0].model.foot_z, 0.0, 0.003);
}

TEST(StaircaseFinderTest, MeasuresTheRiseByTreadsWhereNosingsHideTheTopsOfAllFaces) {
  constexpr double kRise = 0.17, kRun = 0.28, kHidden = 0.04, kNosing = 0.03;
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
  for (int k = 1; k <= 6; ++k) {
    const double x = 3.0 + (k - 1) * kRun, foot = (k - 1) * kRise;
    scene.AddFace(TerrainLabel::kStairRiser, {x, 0.8, foot}, {x, -0.8, foot}, kRise - kHidden, k);
    if (k <= 2)
      scene.AddLevel(TerrainLabel::kStairTread, {x + 0.5 * (kRun - kNosing), 0, k * kRise}, kRun + kNosing,
                     1.6);
  }
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.0, 0.0, 0.5);
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(ShapesOf(scene.Update().changed), {}, sight, true);
  ASSERT_EQ(found.size(), 1u);
  // With the same weight for every kind it would be off by 8 mm.
  EXPECT_NEAR(found[0].model.rise_m, kRise, 0.003);
  EXPECT_NEAR(found[0].model.rise_m, kRise, 2.0 * found[0].rise_sigma_m);
  EXPECT_NEAR(found[0].model.run_m, kRun, 0.002);
}

/// Treads alone, as from above, of which the third lies and leans as its points do that were merged with it.
TEST(StaircaseFinderTest, KnowsALawNoBetterThanTheLevelsAgreeThatItIsMadeOf) {
  constexpr double kRise = 0.165, kRun = 0.3, kPulled = 0.012;
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
  for (int k = 1; k <= 3; ++k) {
    const double low = k == 3 ? kPulled : 0.0;
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + (k - 0.5) * kRun, 0, k * kRise - low}, kRun, 1.6);
  }
  std::vector<PolygonPtr> polygons = scene.Update().changed;
  auto pulled = std::make_shared<Polygon>(*polygons[3]);
  pulled->rms_m = kPulled;
  polygons[3] = pulled;
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(2.0, 0.0, 0.6);
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(ShapesOf(polygons), {}, sight, true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].model.rise_m, kRise, 2.0 * found[0].rise_sigma_m);
  EXPECT_NEAR(found[0].model.rise_m, kRise, 0.003);
}

TEST(StaircaseFinderTest, TakesNoFrontOfATreadForSureOfWhichSomeIsMissing) {
  constexpr double kRise = 0.155, kRun = 0.3;
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
  for (int k = 1; k <= 4; ++k) {
    // Of the last one the front half was lost.
    const double lost = k == 4 ? 0.5 * kRun : 0.0;
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + (k - 0.5) * kRun + 0.5 * lost, 0, k * kRise},
                   kRun - lost, 1.6);
  }
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.6, 0.0, 0.8);
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(ShapesOf(scene.Update().changed), {}, sight, true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].model.run_m, kRun, 0.015);
  EXPECT_NEAR(found[0].model.run_m, kRun, 2.0 * found[0].run_sigma_m);
}

TEST(StaircaseFinderTest, KnowsTheRiseAsWellAsItsSigmaSays) {
  constexpr int kTrials = 60;
  double sum2 = 0.0;
  int num = 0;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    LabelScene scene;
    scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
    KnownFlight flight;
    flight.foot = {3, 0, 0};
    scene.AddFlight(flight);
    const StaircaseFinder finder{StaircaseConfig{}};
    Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
    sight.T_level_left.translation() = Eigen::Vector3d(1.5, 0.0, 1.5);
    // As good as single treads and faces are taken to be.
    const auto found =
        finder.Find(ShapesOf(scene.Update({0.0045, 0.01, 0.012}, seed).changed), {}, sight, true);
    if (found.size() != 1u) continue;
    sum2 += std::pow((found[0].model.rise_m - flight.rise_m) / found[0].rise_sigma_m, 2);
    ++num;
  }
  EXPECT_GE(num, kTrials - 2);
  const double rms = std::sqrt(sum2 / num);
  EXPECT_GT(rms, 0.6);
  EXPECT_LT(rms, 1.4);
}

/// Boards one above the other, 0.155 m from each to the next, each `depth_m` deep and 0.28 m behind the last.
/// @param floor_end_x  how far the floor is seen; the first board begins at 3
LabelScene OpenFlight(int num_treads, double depth_m, double floor_end_x) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {0.5 * floor_end_x, 0, 0}, floor_end_x, 4);
  for (int k = 1; k <= num_treads; ++k)
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + 0.28 * (k - 1) + 0.5 * depth_m, 0, 0.155 * k}, depth_m,
                   0.95);
  return scene;
}

std::vector<FoundStaircase> FindFromBelow(const LabelScene& scene) {
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.8, 0.0, 0.5);
  return StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, sight, true);
}

TEST(StaircaseFinderTest, TellsAnOpenFlightByTwoTreadsWithTheFloorSeenBeneathThem) {
  const auto found = FindFromBelow(OpenFlight(2, 0.28, 5.0));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 2);
  EXPECT_EQ(found[0].foot_shape, 0);
  EXPECT_NEAR(found[0].model.foot_z, 0.0, 0.003);
}

TEST(StaircaseFinderTest, TellsNoFlightWhoseRunIsNotKnown) {
  // Noise of 11 mm, seen from 0.35 m above a tread and 1.5 m away, moves its front by 47 mm.
  PolygonUpdate update = OpenFlight(2, 0.28, 5.0).Update();
  for (PolygonPtr& polygon : update.changed) {
    auto noisy = std::make_shared<Polygon>(*polygon);
    noisy->noise_m = 0.011;
    polygon = noisy;
  }
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.8, 0.0, 0.5);
  const StaircaseFinder finder{StaircaseConfig{}};
  EXPECT_TRUE(finder.Find(ShapesOf(update.changed), {}, sight, true).empty());
}

TEST(StaircaseFinderTest, TellsNoFlightByTwoTopsWithoutTheFloorBeneathThem) {
  EXPECT_TRUE(FindFromBelow(OpenFlight(2, 0.28, 3.0)).empty());
}

TEST(StaircaseFinderTest, TellsNoFlightByTwoFacesBetweenWhichOneIsMissing) {
  // From where no other step would be in view.
  const auto num_found = [](int second) {
    LabelScene scene;
    scene.AddLevel(TerrainLabel::kWalkway, {1.5, -1.5, 0}, 5, 3);
    for (const int k : {1, second}) {
      const double y = 0.25 * (k - 1), z = 0.2 * (k - 1);
      scene.AddFace(TerrainLabel::kObstacle, {2.5, y, z}, {3.5, y, z}, 0.2);
    }
    Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
    sight.T_level_left.translation() = Eigen::Vector3d(0.0, 1.0, 0.5);
    return StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, sight, true).size();
  };
  EXPECT_EQ(num_found(2), 1u);
  EXPECT_EQ(num_found(3), 0u);
}

TEST(StaircaseFinderTest, TakesTheFloorBeneathAnOpenFlightForItsFootAndNoTread) {
  // Boards that reach under one another are deeper than the run.
  const auto found = FindFromBelow(OpenFlight(3, 0.335, 5.0));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 3);
  EXPECT_EQ(found[0].num_treads, 3);
  EXPECT_EQ(found[0].foot_shape, 0);
  ASSERT_EQ(found[0].members.size(), 3u);
  EXPECT_EQ(found[0].members[0].step_index, 1);
}

TEST(StaircaseFinderTest, MissesNoRisersWhereTheyAreOpen) {
  // Three treads are in view, the next are above the image and the landing is not seen.
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {2.5, 0, 0}, 5, 4);
  for (int k = 1; k <= 2; ++k)
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + 0.28 * (k - 0.5), 0, 0.155 * k}, 0.30, 0.95);
  // Of the third two fragments.
  for (const double side : {-0.25, 0.25})
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + 0.28 * 2.5, side, 0.155 * 3}, 0.30, 0.45);
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.8, 0.0, 0.5);
  const StaircaseFinder finder{StaircaseConfig{}};
  const auto found = finder.Find(ShapesOf(scene.Update().changed), {}, sight, true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 3);
  EXPECT_NEAR(found[0].model.rise_m, 0.155, 0.002);
}

/// What is seen below an edge.
struct BelowAnEdge {
  double floor_below_m = 0.45;
  std::vector<Interval> tread_across{{-0.6, 1.0}};  ///< each fragment of it
  double shows_m = 0.1;                             ///< of the tread
  double floor_width_m = 2.0;                       ///< of what shows of the floor below
};

/// The floor above an edge, what shows of one tread below it, and the floor below.
std::vector<FoundStaircase> FindBelowAnEdge(const BelowAnEdge& below = {}) {
  constexpr double kRise = 0.15, kRun = 0.28;
  LabelScene scene;
  // Beside the flight the floor above goes on.
  KnownPiece floor;
  floor.outline = {{-1, -2, 0},     {kEdgeX + 1, -2, 0}, {kEdgeX + 1, -1, 0},
                   {kEdgeX, -1, 0}, {kEdgeX, 2, 0},      {-1, 2, 0}};
  scene.Add(floor);
  // From where it shows over the edge on.
  scene.AddLevel(TerrainLabel::kWalkway, {5.87, 0, -below.floor_below_m}, 4.26, below.floor_width_m);
  for (const Interval& across : below.tread_across)
    scene.AddLevel(TerrainLabel::kStairTread, {kEdgeX + kRun - 0.5 * below.shows_m, across.middle(), -kRise},
                   below.shows_m, across.length());
  return StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, FromAbove(), true);
}

TEST(StaircaseFinderTest, TellsAFlightDownByTheEdgeAboveItAndOneTread) {
  const auto found = FindBelowAnEdge();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 3);
  EXPECT_NEAR(found[0].model.rise_m, 0.15, 0.002);
  EXPECT_NEAR(found[0].model.run_m, 0.28, 0.01);
  EXPECT_LT(found[0].run_sigma_m, 0.2 * 0.28);
  EXPECT_LT(found[0].model.UpAt(1.0).x(), -0.99);
  EXPECT_EQ(found[0].head_shape, 0);
  EXPECT_EQ(found[0].foot_shape, 1);
}

TEST(StaircaseFinderTest, TellsAFlightDownByTheFirstStripOfATreadThatShows) {
  const auto found = FindBelowAnEdge({0.45, {{-0.6, 1.0}}, 0.045});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 3);
}

TEST(StaircaseFinderTest, TellsAFlightDownByANarrowFragmentOfATreadUnlessTheFloorShowsBesideIt) {
  BelowAnEdge below{.tread_across = {{-0.2, 0.4}}, .floor_width_m = 0.9};
  EXPECT_EQ(FindBelowAnEdge(below).size(), 1u) << "steps hide the floor to either side";
  below.floor_width_m = 2.0;
  EXPECT_TRUE(FindBelowAnEdge(below).empty());
}

TEST(StaircaseFinderTest, TakesTheFragmentsOfATreadForOneStepAsWideAsTheyReach) {
  const auto found = FindBelowAnEdge({0.45, {{-0.6, -0.25}, {0.65, 1.0}}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].model.lateral.length(), 1.6, 0.02);
}

TEST(StaircaseFinderTest, TellsNoFlightDownByALedgeAlone) {
  EXPECT_TRUE(FindBelowAnEdge({0.375}).empty()) << "the floor below lies at no whole number of steps";
  EXPECT_TRUE(FindBelowAnEdge({0.45, {{-0.05, 0.45}}}).empty()) << "both sides of it are in view: a box";
}

/// By two faces and, behind and above them, two steep strips, each a face with some of the treads beside it.
/// @param aside_m  how far the strips lie behind the place of their faces
std::vector<FoundStaircase> FindByFacesAndStrips(int num_strips, double aside_m) {
  constexpr double kRise = 0.174, kRun = 0.288;
  LabelScene scene;
  for (int k = 0; k < 2 + num_strips; ++k) {
    const double x = kEdgeX + k * kRun, z = (k + 0.5) * kRise;
    const double half_x = k < 2 ? 0.0 : 0.07, half_z = k < 2 ? 0.5 * kRise : 0.085;
    const double low_x = x - half_x + (k < 2 ? 0.0 : aside_m), high_x = low_x + 2.0 * half_x;
    scene.Add({{{low_x, 0.5, z - half_z},
                {low_x, -0.5, z - half_z},
                {high_x, -0.5, z + half_z},
                {high_x, 0.5, z + half_z}},
               {},
               TerrainLabel::kStairRiser});
  }
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(kEdgeX - 0.9, 0.0, 0.24);
  return StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, sight, true);
}

TEST(StaircaseFinderTest, TellsAFlightSeenFromLowByFacesOfWhichTheFarOnesHaveMergedWithTheirTreads) {
  const auto found = FindByFacesAndStrips(2, 0.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 4);
  EXPECT_NEAR(found[0].model.rise_m, 0.174, 0.006);
  EXPECT_NEAR(found[0].model.run_m, 0.288, 0.015);
  for (const StepMember& member : found[0].members) EXPECT_EQ(member.only_evidence, member.step_index > 2);
  EXPECT_TRUE(FindByFacesAndStrips(0, 0.0).empty());
  EXPECT_TRUE(FindByFacesAndStrips(2, 0.3).empty()) << "strips that lie at no place of a face";
}

TEST(StaircaseFinderTest, CountsAFlightDownByItsFirstTreadsAndTheFloorBelow) {
  // The edges of the steps hide all but the fronts of the treads; farther down they merge.
  constexpr int kRisers = 8;
  constexpr double kRise = 0.14, kRun = 0.26;
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 2.0 * (kEdgeX - 1), 1.6);
  for (int k = 1; k <= 2; ++k)
    scene.AddLevel(TerrainLabel::kStairTread, {kEdgeX + k * kRun - 0.04, 0, -k * kRise}, 0.08, 1.6);
  const double foot_x = kEdgeX + (kRisers - 1) * kRun;
  scene.AddLevel(TerrainLabel::kWalkway, {foot_x + 1.7, 0, -kRisers * kRise}, 3, 1.6);
  Sight sight = FromAbove();
  sight.T_level_left.translation().x() = kEdgeX - 0.6;
  const auto found =
      StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, sight, true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, kRisers);
  EXPECT_NEAR(found[0].model.rise_m, kRise, 0.002);
  EXPECT_NEAR(found[0].model.run_m, kRun, 0.01);
  EXPECT_EQ(found[0].evidence.num_to_see, 2);
}

TEST(StaircaseFinderTest, MissesNoTreadInASlopeInWhichStepsFarDownHaveMerged) {
  constexpr int kRisers = 7;
  const double foot_x = kEdgeX + (kRisers - 1) * kRunDown;
  for (const bool merged : {false, true}) {
    LabelScene scene;
    scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 2.0 * (kEdgeX - 1), 1.6);
    for (int k = 1; k <= 2; ++k)
      scene.AddLevel(TerrainLabel::kStairTread, {kEdgeX + k * kRunDown - 0.08, 0, -k * kRiseDown}, 0.16, 1.6);
    scene.AddLevel(TerrainLabel::kWalkway, {foot_x + 1.7, 0, -kRisers * kRiseDown}, 3, 1.6);
    if (merged) {
      const auto z = [](double x) { return -(x - kEdgeX) * kRiseDown / kRunDown; };
      const double a = kEdgeX + 2.1 * kRunDown, b = foot_x;
      scene.Add(
          {{{a, -0.8, z(a)}, {b, -0.8, z(b)}, {b, 0.8, z(b)}, {a, 0.8, z(a)}}, {}, TerrainLabel::kUnknown});
    }
    Sight sight = FromAbove();
    sight.T_level_left.translation().x() = kEdgeX - 0.2;  // most of every tread could be seen
    const auto found =
        StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, sight, true);
    if (!merged) {
      EXPECT_TRUE(found.empty()) << "four treads are not where they could be seen";
      continue;
    }
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].num_risers, kRisers);
    EXPECT_EQ(found[0].evidence.num_seen, 2);
    EXPECT_EQ(found[0].evidence.num_to_see, 2);
  }
}

TEST(StaircaseFinderTest, ClaimsNoFloorThatLiesAtNoWholeNumberOfSteps) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 2.0 * (kEdgeX - 1), 1.6);
  for (int k = 1; k <= 2; ++k)
    scene.AddLevel(TerrainLabel::kStairTread, {kEdgeX + k * 0.26 - 0.04, 0, -k * 0.2}, 0.08, 1.6);
  scene.AddLevel(TerrainLabel::kWalkway, {kEdgeX + 7 * 0.26 + 1.7, 0, -7.5 * 0.2}, 3, 1.6);
  Sight sight = FromAbove();
  sight.T_level_left.translation().x() = kEdgeX - 0.6;
  for (const FoundStaircase& staircase :
       StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(scene.Update().changed), {}, sight, true))
    EXPECT_FALSE(staircase.foot_shape);
}

/// A level rectangle of which the underside is seen.
KnownPiece BoardFromBelow(double front_x, double depth_m, double width_m, double z) {
  const double a = front_x, b = front_x + depth_m, w = 0.5 * width_m;
  return {{{a, -w, z}, {a, w, z}, {b, w, z}, {b, -w, z}}, {}, TerrainLabel::kUnknown};
}

TEST(StaircaseFinderTest, CountsTheLastRiserOfAnOpenFlightByTheBlockThatItsLandingStandsOn) {
  const auto risers_before_face = [](double height_m, double behind_m) {
    LabelScene scene = OpenFlight(3, 0.28, 3.9);
    const double x = 3.0 + 3 * 0.28 + behind_m;
    scene.AddFace(TerrainLabel::kObstacle, {x, 0.5, 0}, {x, -0.5, 0}, height_m);
    const auto found = FindFromBelow(scene);
    return found.size() == 1u ? found[0].num_risers : 0;
  };
  EXPECT_EQ(risers_before_face(4 * 0.155, 0.0), 4);
  EXPECT_EQ(risers_before_face(1.5, 0.0), 3) << "a wall";
  EXPECT_EQ(risers_before_face(4 * 0.155, 0.2), 3) << "no riser stands there";
}

TEST(StaircaseFinderTest, CountsTheBoardOfALandingThatIsSeenFromBelowAndDeeperThanATread) {
  LabelScene scene = OpenFlight(3, 0.28, 3.9);
  KnownPiece board;
  const double x = 3.0 + 3 * 0.28, z = 4 * 0.155 - 0.04;
  board.outline = {{x, -0.47, z}, {x, 0.47, z}, {x + 0.9, 0.47, z}, {x + 0.9, -0.47, z}};
  scene.Add(board);
  const auto found = FindFromBelow(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 4);
}

TEST(StaircaseFinderTest, TakesBothSidesOfAFlightAlikeWhereHalfOfItsFacesAreCutOff) {
  LabelScene scene;
  scene.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
  for (int k = 1; k <= 4; ++k) {
    const double x = 3.0 + 0.28 * (k - 1), z = 0.17 * (k - 1);
    const double left = k % 2 == 0 ? 0.8 : 0.5, right = k % 2 == 0 ? -0.5 : -0.8;
    scene.AddFace(TerrainLabel::kStairRiser, {x, left, z}, {x, right, z}, 0.17, k);
  }
  const auto found = FindFromBelow(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].model.lateral.low, -0.8, 0.01);
  EXPECT_NEAR(found[0].model.lateral.high, 0.8, 0.01);
}

/// Seven steps about the axis z to the left, and a floor before them.
struct SpiralScene {
  static constexpr double kInner = 0.25, kHidden = 0.8, kOuter = 1.45, kTurn = 0.36;

  /// @param num_whole  steps that are seen as far as the inner side; the others only beyond kHidden
  static FoundStaircase Find(int num_whole) {
    LabelScene whole, outer;
    whole.AddSpiral({0, 0, 0}, kInner, kOuter, 7, 0.17, kTurn);
    whole.AddLevel(TerrainLabel::kWalkway, {0.85, -1, 0}, 2, 2);
    outer.AddSpiral({0, 0, 0}, kHidden, kOuter, 7, 0.17, kTurn);
    std::vector<PolygonPtr> polygons = whole.Update().changed;
    const std::vector<PolygonPtr> far = outer.Update().changed;
    std::copy(far.begin() + 2 * num_whole, far.end(), polygons.begin() + 2 * num_whole);
    Sight sight;
    sight.T_level_left.translation() = Eigen::Vector3d(0.85, -1.5, 0.5);
    const auto found = StaircaseFinder{StaircaseConfig{}}.Find(ShapesOf(polygons), {}, sight, true);
    return found.size() == 1 && found[0].model.spiral ? found[0] : FoundStaircase{};
  }
};

TEST(StaircaseFinderTest, FindsTheInnerSideOfASpiralWhereItsLowerStepsHideThoseFartherUp) {
  const FlightModel model = SpiralScene::Find(2).model;
  EXPECT_NEAR(model.lateral.low, SpiralScene::kInner, 0.02);
  EXPECT_NEAR(model.lateral.high, SpiralScene::kOuter, 0.02);
  EXPECT_NEAR(model.run_m / model.radius_m, SpiralScene::kTurn, 0.01);
}

TEST(StaircaseFinderTest, KnowsTheTreadsOfASpiralTheWorseTheLessOfItsInnerSideShows) {
  const FoundStaircase whole = SpiralScene::Find(7), outer = SpiralScene::Find(0);
  const double middle_is_off_m = 0.5 * (SpiralScene::kHidden - SpiralScene::kInner);
  EXPECT_NEAR(outer.model.lateral.low, SpiralScene::kHidden, 0.02);
  EXPECT_GT(2.0 * outer.run_sigma_m, middle_is_off_m * SpiralScene::kTurn);
  EXPECT_LT(whole.run_sigma_m, 0.1 * SpiralScene::kTurn);
}

/// A floor, the first risers with their treads, and above them risers up to 7 that have merged into inclines
/// from afar.
struct StepsBelowInclines {
  int num_risers = 4;
  double steps_noise_m = 0.003;
  bool treads = true;
  std::vector<std::pair<double, double>> inclines = {{4.7, 7.3}};  ///< each from one riser to another
  double rms_m = 0.013;                                            ///< of the inclines

  std::vector<RegionShapePtr> Shapes() const {
    constexpr double kRise = 0.17, kRun = 0.28;
    LabelScene scene;
    KnownFlight flight;
    flight.foot = {3, 0, 0};
    flight.num_risers = num_risers;
    flight.width_m = 1.6;
    scene.AddFlight(flight);
    const std::size_t num_steps = scene.Update().changed.size();
    const auto on_line = [&](double k, double y) {
      return Eigen::Vector3d(3.0 + (k - 1.0) * kRun, y, (k - 0.5) * kRise);
    };
    for (const auto& [low, high] : inclines)
      scene.Add({{on_line(low, -0.8), on_line(high, -0.8), on_line(high, 0.8), on_line(low, 0.8)}, {}});
    std::vector<PolygonPtr> polygons = scene.Update().changed;
    for (std::size_t i = 0; i < polygons.size(); ++i) {
      auto polygon = std::make_shared<Polygon>(*polygons[i]);
      polygon->noise_m = i < num_steps ? steps_noise_m : 0.006;
      if (i >= num_steps) polygon->rms_m = rms_m;
      polygons[i] = polygon;
    }
    if (!treads)
      std::erase_if(polygons, [](const PolygonPtr& p) { return p->plane_world.normal.z() > 0.99; });
    LabelScene floor;
    floor.AddLevel(TerrainLabel::kWalkway, {1, 0, 0}, 4, 1.6);
    auto ground = std::make_shared<Polygon>(*floor.Update().changed.front());
    ground->id = 1000;
    polygons.push_back(ground);
    return ShapesOf(polygons);
  }
  std::vector<FoundStaircase> Find() const {
    Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
    sight.T_level_left.translation() = Eigen::Vector3d(2.0, 0.0, 0.75);
    return StaircaseFinder{StaircaseConfig{}}.Find(Shapes(), {}, sight, true);
  }
};

TEST(StaircaseFinderTest, CountsTheStepsThatHaveMergedIntoOneInclineAboveTheOthers) {
  const auto found = StepsBelowInclines{}.Find();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 7);
  EXPECT_EQ(found[0].num_treads, 6);
}

TEST(StaircaseFinderTest, CountsAStepBetweenTwoThatHaveMergedIntoInclines) {
  const auto found = StepsBelowInclines{.inclines = {{4.7, 5.4}, {6.6, 7.3}}}.Find();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 7);
}

TEST(StaircaseFinderTest, TellsTwoBlurredFacesWhereAnInclineThatIsNoPlaneGoesOnAsTheyDo) {
  StepsBelowInclines scene{
      .num_risers = 2, .steps_noise_m = 0.012, .treads = false, .inclines = {{2.7, 7.3}}};
  const auto found = scene.Find();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 7);
  EXPECT_NEAR(found[0].model.rise_m, 0.17, 0.005);
  scene.rms_m = 0.003;  // a ramp
  EXPECT_TRUE(scene.Find().empty());
  scene.inclines.clear();
  EXPECT_TRUE(scene.Find().empty());
}

TEST(StaircaseFinderTest, CountsNoStepsInARampAboveAFlight) {
  const auto found = StepsBelowInclines{.rms_m = 0.003}.Find();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].num_risers, 4);
}

TEST(StaircaseFinderTest, CountsTheBoardsOfAnOpenFlightThatAreSeenFromBelow) {
  constexpr double kRise = 0.17, kRun = 0.28;
  for (const double board_m : {0.03, 0.045, 0.06}) {
    LabelScene scene;
    scene.AddLevel(TerrainLabel::kWalkway, {2.5, 0, 0}, 5, 4);
    for (int k = 1; k <= 2; ++k)
      scene.AddLevel(TerrainLabel::kStairTread, {3.0 + kRun * (k - 0.5), 0, kRise * k}, 0.28, 0.95);
    for (int k = 4; k <= 6; ++k)
      scene.Add(BoardFromBelow(3.0 + kRun * (k - 1), 0.28, 0.95, kRise * k - board_m));
    const auto found = FindFromBelow(scene);
    ASSERT_EQ(found.size(), 1u) << board_m;
    EXPECT_EQ(found[0].num_risers, 6) << board_m;
    EXPECT_NEAR(found[0].model.rise_m, kRise, 0.002) << board_m;
    EXPECT_EQ(std::count_if(found[0].members.begin(), found[0].members.end(),
                            [](const StepMember& m) { return m.only_evidence; }),
              3)
        << board_m;
  }
}

TEST(StaircaseFinderTest, FindsNoSecondFlightAmongTheStepsOfOne) {
  // Things lie on the treads, as far apart as these and nearer to the edges.
  LabelScene scene = OpenFlight(5, 0.28, 5.0);
  for (int k = 1; k <= 4; ++k)
    scene.AddLevel(TerrainLabel::kObstacle, {3.0 + 0.28 * (k - 1) + 0.02, 0, 0.155 * k + 0.075}, 0.2, 0.6);
  EXPECT_EQ(FindFromBelow(scene).size(), 1u);
}

TEST(StaircaseFinderTest, TakesStepsThatGoOnToASideForTheSameFlight) {
  // Of one side the fronts are hidden, so that it does not obey the law of the other.
  LabelScene scene = OpenFlight(5, 0.28, 5.0);
  for (int k = 1; k <= 5; ++k)
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + 0.28 * (k - 1) + 0.21, 0.78, 0.155 * k}, 0.2, 0.55);
  EXPECT_EQ(FindFromBelow(scene).size(), 1u);
}

TEST(StaircaseFinderTest, FindsNoSecondFlightWithinTheWidthOfAKnownOne) {
  // Its middle is hidden, and on the far side so are the fronts.
  LabelScene scene = OpenFlight(5, 0.28, 5.0);
  for (int k = 1; k <= 5; ++k)
    scene.AddLevel(TerrainLabel::kStairTread, {3.0 + 0.28 * (k - 1) + 0.21, 1.2, 0.155 * k}, 0.2, 0.55);
  const std::vector<RegionShapePtr> shapes = ShapesOf(scene.Update().changed);
  Sight sight{TestCamera(), Eigen::Isometry3d(TestBodyLeft()), 0.0};
  sight.T_level_left.translation() = Eigen::Vector3d(1.8, 0.0, 0.5);
  const StaircaseFinder finder{StaircaseConfig{}};
  EXPECT_EQ(finder.Find(shapes, {}, sight, true).size(), 2u);
  FlightModel known;
  known.origin = {3.0, 0.0};
  known.rise_m = 0.155;
  known.run_m = 0.28;
  known.lateral = {-0.475, 1.475};
  EXPECT_EQ(finder.Find(shapes, {known}, sight, true).size(), 1u);
  EXPECT_EQ(finder.Find(shapes, {known}, sight, false).size(), 1u);
}

TEST(StaircaseFinderTest, TakesStripsForStepsOnlyWhereTheyAreHigherThanNoiseHides) {
  const auto candidates = [](double rms_m, double noise_m) {
    std::vector<RegionShapePtr> shapes = InclineInStrips(rms_m);
    for (RegionShapePtr& shape : shapes) {
      auto polygon = std::make_shared<Polygon>(*shape->polygon);
      polygon->noise_m = noise_m;
      auto noisy = std::make_shared<RegionShape>(*shape);
      noisy->polygon = polygon;
      shape = noisy;
    }
    const StaircaseConfig config;
    const StraightFrame frame(-Eigen::Vector2d::UnitX());
    std::vector<StepElement> strips =
        MeasureSteps(config, shapes, StepCandidates(config, shapes, FromAbove().eye()), frame);
    std::erase_if(strips, [](const StepElement& e) { return !e.leaning; });
    return strips;
  };
  // Noise of 9 mm hides steps of 5 cm, but not of 11 cm.
  const std::vector<StepElement> strips = candidates(0.013, 0.009);
  ASSERT_EQ(strips.size(), 3u);
  EXPECT_GT(strips[0].min_rise_m, StaircaseConfig{}.min_riser_m);
  EXPECT_LT(strips[0].min_rise_m, kRiseDown);
  EXPECT_TRUE(candidates(0.008, 0.009).empty()) << "noise explains what departs from the plane";
  Stride stride{kEdgeX - 4 * kRunDown, kRunDown, -4 * kRiseDown, 0.055, {-0.8, 0.8}};
  EXPECT_FALSE(FitStep(StaircaseConfig{}, StraightFrame(-Eigen::Vector2d::UnitX()), stride, strips[0]));
}

}  // namespace
}  // namespace terrace
