// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_query.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/client/made_terrain.h"

namespace terrace {
namespace {

using testing::ElementsAre;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The outline and the holes, one after the other.
std::vector<Ring> RingsOf(const TerrainRegion& region) {
  std::vector<Ring> rings{region.outline_world};
  rings.insert(rings.end(), region.holes_world.begin(), region.holes_world.end());
  return rings;
}

/// The slow obvious versions: every edge of every region is looked at.
bool SlowlyInside(const TerrainRegion& region, const Eigen::Vector2d& xy) {
  bool inside = false;
  for (const Ring& ring : RingsOf(region)) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector3d a = ring[i], b = ring[(i + 1) % ring.size()];
      if ((a.y() > xy.y()) == (b.y() > xy.y())) continue;
      if (xy.x() < a.x() + (xy.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
    }
  }
  return inside;
}

/// Distance to the nearest edge of a kind; of any kind: none given.
double SlowEdgeDistance(const TerrainRegion& region, const Eigen::Vector3d& p,
                        std::optional<EdgeKind> kind = {}) {
  double nearest = kInfinity;
  std::size_t edge = 0;
  for (const Ring& ring : RingsOf(region)) {
    for (std::size_t i = 0; i < ring.size(); ++i, ++edge) {
      if (kind && region.edges[edge].kind != *kind) continue;
      const Eigen::Vector3d a = ring[i], along = ring[(i + 1) % ring.size()] - a;
      const double t = std::clamp(along.dot(p - a) / along.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (a + t * along - p).norm());
    }
  }
  return nearest;
}

double HeightOn(const TerrainRegion& region, const Eigen::Vector2d& xy) {
  const Plane& plane = region.plane_world;
  return (plane.offset_m - plane.normal.head<2>().dot(xy)) / plane.normal.z();
}

/// All ground at (x, y) by height, the highest first.
std::vector<std::pair<double, const TerrainRegion*>> SlowSupports(const TerrainMap& map,
                                                                  const Eigen::Vector2d& xy) {
  std::vector<std::pair<double, const TerrainRegion*>> found;
  for (const auto& region : map.regions) {
    if (region->plane_world.normal.z() > 0.5 && SlowlyInside(*region, xy))
      found.emplace_back(HeightOn(*region, xy), region.get());
  }
  std::sort(found.rbegin(), found.rend());
  return found;
}

bool KeepsClear(const TerrainRegion& region, const Eigen::Vector3d& p, const FootSpec& foot, double slack_m) {
  return SlowEdgeDistance(region, p) >= foot.radius_m + slack_m &&
         SlowEdgeDistance(region, p, EdgeKind::kDrop) >= foot.radius_m + foot.clear_drop_m + slack_m &&
         SlowEdgeDistance(region, p, EdgeKind::kRise) >= foot.radius_m + foot.clear_rise_m + slack_m;
}

bool SlowlyFits(const TerrainMap& map, const TerrainRegion& region, const FootSpec& foot) {
  return region.plane_world.normal.z() > 0.5 && foot.labels.Has(region.label) &&
         region.confidence >= foot.min_confidence && (foot.allow_predicted || !region.predicted()) &&
         Seconds(map.t_capture - region.last_seen) <= foot.max_age_s &&
         std::acos(region.plane_world.normal.z()) <= foot.max_slope_rad;
}

TEST(TerrainQueryTest, FindsTheSameGroundAsALookAtEveryRegion) {
  ScatteredTerrain terrain(1);
  const TerrainQuery query(terrain.Map(200, 3.0));
  int num_found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d xy(terrain.Real(-3, 3), terrain.Real(-3, 3));
    const auto slow = SlowSupports(query.map(), xy);
    const std::vector<Support> fast = query.SupportsAt(xy);
    ASSERT_EQ(fast.size(), slow.size());
    for (std::size_t k = 0; k < fast.size(); ++k) {
      EXPECT_EQ(fast[k].region_id, slow[k].second->id);
      EXPECT_NEAR(fast[k].point_world.z(), slow[k].first, 1e-9);
      EXPECT_NEAR(fast[k].edge_distance_m, SlowEdgeDistance(*slow[k].second, fast[k].point_world), 1e-9);
      EXPECT_NEAR(SlowEdgeDistance(*slow[k].second, fast[k].point_world, fast[k].edge.kind),
                  fast[k].edge_distance_m, 1e-9);
    }
    const auto best = std::find_if(slow.begin(), slow.end(), [](const auto& entry) {
      return entry.first <= 0.8 && entry.first >= 0.1 && kWalkableLabels.Has(entry.second->label);
    });
    const auto support = query.SupportAt(xy, 0.1, 0.8);
    ASSERT_EQ(support.has_value(), best != slow.end());
    if (!support) continue;
    EXPECT_EQ(support->region_id, best->second->id);
    ++num_found;
  }
  EXPECT_GT(num_found, 200);
}

TEST(TerrainQueryTest, TellsLabelEdgeAgeAndSourceOfTheGround) {
  auto tread = MadeRegion(7, TerrainLabel::kStairTread, LevelAt(0.17), Rectangle(0, 0, 0.3, 1.2));
  tread->edges[3] = {EdgeKind::kDrop, -0.17, 0.004};  // x = 0
  tread->source = RegionSource::kPredicted;
  const TerrainQuery query(MadeMap({tread}));
  const auto support = query.SupportAt({0.1, 0.6}, -1, 1);
  ASSERT_TRUE(support);
  EXPECT_EQ(support->region_id, 7);
  EXPECT_EQ(support->label, TerrainLabel::kStairTread);
  EXPECT_DOUBLE_EQ(support->confidence, 0.9);
  EXPECT_NEAR(support->edge_distance_m, 0.1, 1e-12);
  EXPECT_EQ(support->edge.kind, EdgeKind::kDrop);
  EXPECT_DOUBLE_EQ(*support->edge.step_m, -0.17);
  EXPECT_DOUBLE_EQ(support->age_s, 2.0);
  EXPECT_EQ(support->source, RegionSource::kPredicted);
  EXPECT_FALSE(query.SupportAt({0.4, 0.6}, -1, 1)) << "nothing is known beyond the edge";
  EXPECT_FALSE(query.SupportAt({0.1, 0.6}, 0.2, 1));
  EXPECT_FALSE(query.SupportAt({0.1, 0.6}, -1, 1, {TerrainLabel::kWalkway}));
}

TEST(TerrainQueryTest, SigmaOfHeightIsWhatPlanesDrawnFromTheCovarianceScatterBy) {
  Plane plane{Eigen::Vector3d(0.2, -0.3, 1.0).normalized(), 0.4};
  const auto region = MadeRegion(1, TerrainLabel::kRamp, plane, Rectangle(-2, -1, 2, 1));
  const TerrainQuery query(MadeMap({region}));
  const Eigen::Vector2d xy(1.5, 0.7);
  const double told = query.SupportAt(xy, -5, 5)->sigma_height_m;
  // Turn and shift the plane by draws, and see where it then is over the same place.
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const PlaneAxes axes = AxesOf(plane.normal);
  double sum_squares = 0.0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d d = region->plane_covariance.diagonal().cwiseSqrt().cwiseProduct(
        Eigen::Vector3d(normal(random), normal(random), normal(random)));
    const Eigen::Vector3d turned =
        Eigen::AngleAxisd(d.x(), axes.x) * (Eigen::AngleAxisd(d.y(), axes.y) * plane.normal);
    const Eigen::Vector3d point = region->centroid_world + d.z() * plane.normal;
    const double z = (turned.dot(point) - turned.head<2>().dot(xy)) / turned.z();
    sum_squares += std::pow(z - HeightOn(*region, xy), 2);
  }
  EXPECT_NEAR(told, std::sqrt(sum_squares / kDraws), 0.03 * told);
}

TEST(TerrainQueryTest, APlaneWithoutCovarianceIsNotKnownExactlyButNotKnown) {
  const auto region = MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), Rectangle(-1, -1, 1, 1));
  region->plane_covariance.setZero();
  const TerrainQuery query(MadeMap({region}));
  EXPECT_TRUE(std::isnan(query.SupportAt({0, 0}, -1, 1)->sigma_height_m));
  const HeightCell cell = query.Heights({}).at(10, 10);
  EXPECT_TRUE(cell.known());
  EXPECT_TRUE(std::isnan(cell.sigma_m));
}

TEST(TerrainQueryTest, FootholdsKeepClearOfEdgesByTheirKindAndNoneNearerIsMissed) {
  ScatteredTerrain terrain(2);
  const TerrainQuery query(terrain.Map(60, 2.0));
  FootSpec foot;
  foot.max_age_s = 8.0;
  int num_found = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d nominal(terrain.Real(-2, 2), terrain.Real(-2, 2), terrain.Real(-0.2, 1.7));
    constexpr double kReach = 0.4, kRise = 0.3;
    const auto found = query.NearestFoothold(nominal, kReach, kRise, foot);
    if (found) {
      ++num_found;
      const TerrainRegion& region = *query.Find(found->support.region_id)->region;
      const Eigen::Vector3d& p = found->support.point_world;
      EXPECT_TRUE(SlowlyInside(region, p.head<2>()));
      EXPECT_TRUE(SlowlyFits(query.map(), region, foot));
      // Whole micrometres are what insets are counted in.
      EXPECT_TRUE(KeepsClear(region, p, foot, -3e-6)) << "region " << region.id;
      EXPECT_LE((p - nominal).head<2>().norm(), kReach);
      EXPECT_LE(std::abs(p.z() - nominal.z()), kRise);
      EXPECT_NEAR(found->distance_m, (p - nominal).norm(), 1e-9);
    }
    // Places on a grid, which a foot can take even a millimetre further in.
    for (const auto& region : query.map().regions) {
      if (!SlowlyFits(query.map(), *region, foot)) continue;
      for (double x = -kReach; x <= kReach; x += 0.04) {
        for (double y = -kReach; y <= kReach; y += 0.04) {
          const Eigen::Vector2d xy = nominal.head<2>() + Eigen::Vector2d(x, y);
          const Eigen::Vector3d p(xy.x(), xy.y(), HeightOn(*region, xy));
          // The point of a region that is nearest must be within reach itself: away from the border of the
          // reach.
          if ((p - nominal).norm() > std::min(kReach, kRise) || !SlowlyInside(*region, xy)) continue;
          if (!KeepsClear(*region, p, foot, 1.1e-3)) continue;
          ASSERT_TRUE(found);
          EXPECT_LE(found->distance_m, (p - nominal).norm() + 1e-9);
        }
      }
    }
  }
  EXPECT_GT(num_found, 50);
}

TEST(TerrainQueryTest, OffersNoFootholdOnWhatIsOldSteepPredictedOrDoubtful) {
  const auto offered = [](const std::shared_ptr<TerrainRegion>& region, const FootSpec& foot) {
    return TerrainQuery(MadeMap({region})).NearestFoothold({0, 0, 0}, 0.5, 0.5, foot).has_value();
  };
  const auto floor = [] {
    return MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), Rectangle(-1, -1, 1, 1));
  };
  FootSpec foot;
  EXPECT_TRUE(offered(floor(), foot));
  foot.max_age_s = 1.0;
  EXPECT_FALSE(offered(floor(), foot)) << "seen two seconds ago";
  foot = {};
  auto region = floor();
  region->source = RegionSource::kPredicted;
  EXPECT_FALSE(offered(region, foot));
  foot.allow_predicted = true;
  EXPECT_TRUE(offered(region, foot));
  region = floor();
  region->confidence = 0.4;
  EXPECT_FALSE(offered(region, foot));
  region = floor();
  region->label = TerrainLabel::kObstacle;
  EXPECT_FALSE(offered(region, foot));
  foot.max_slope_rad = 0.1;
  region = MadeRegion(1, TerrainLabel::kRamp, {Eigen::Vector3d(0.2, 0, 1).normalized(), 0},
                      Rectangle(-1, -1, 1, 1));
  EXPECT_FALSE(offered(region, foot));
  foot.max_slope_rad = 0.3;
  EXPECT_TRUE(offered(region, foot));
}

TEST(TerrainQueryTest, AThinTreadIsWideEnoughForASmallFootOnly) {
  const auto tread = MadeRegion(1, TerrainLabel::kStairTread, LevelAt(0), Rectangle(0, 0, 0.1, 1));
  const TerrainQuery query(MadeMap({tread}));
  FootSpec foot;
  foot.radius_m = 0.049;
  EXPECT_TRUE(query.NearestFoothold({0.05, 0.5, 0}, 0.5, 0.1, foot));
  foot.radius_m = 0.051;
  EXPECT_FALSE(query.NearestFoothold({0.05, 0.5, 0}, 0.5, 0.1, foot));
}

TEST(TerrainQueryTest, HeightsAreThoseOfTheHighestGroundAndUnknownWhereNothingIsKnown) {
  ScatteredTerrain terrain(3);
  const TerrainQuery query(terrain.Map(40, 2.0));
  HeightGridSpec spec;
  spec.first_xy = {-2.3, -2.1};
  spec.cell_m = 0.05;
  spec.num_x = 90;
  spec.num_y = 80;
  spec.z_max = 1.2;
  const HeightGrid grid = query.Heights(spec);
  int num_known = 0;
  for (int i = 0; i < spec.num_x; ++i) {
    for (int j = 0; j < spec.num_y; ++j) {
      const HeightCell& cell = grid.at(i, j);
      const auto support = query.SupportAt(spec.first_xy + spec.cell_m * Eigen::Vector2d(i, j), -kInfinity,
                                           spec.z_max, kAllLabels);
      ASSERT_EQ(cell.known(), support.has_value());
      EXPECT_EQ(cell.known(), !std::isnan(cell.height_m));
      if (!support) continue;
      ++num_known;
      EXPECT_EQ(cell.region_id, support->region_id);
      EXPECT_EQ(cell.label, support->label);
      EXPECT_EQ(cell.predicted, support->source == RegionSource::kPredicted);
      EXPECT_NEAR(cell.height_m, support->point_world.z(), 1e-6);
      EXPECT_NEAR(cell.sigma_m, support->sigma_height_m, 1e-6);
      EXPECT_NEAR(cell.age_s, support->age_s, 1e-6);
    }
  }
  EXPECT_GT(num_known, 1500);
  EXPECT_LT(num_known, spec.num_x * spec.num_y - 500);
}

TEST(TerrainQueryTest, FindsTheRegionsThatReachIntoABoxAndNoneThatOnlySurroundsIt) {
  const auto floor =
      MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), Rectangle(-5, -5, 5, 5), {Rectangle(-1, -1, 1, 1)});
  const auto box_top = MadeRegion(2, TerrainLabel::kObstacle, LevelAt(0.4), Rectangle(-0.5, -0.5, 0.5, 0.5));
  const auto slope = MadeRegion(3, TerrainLabel::kRamp, {Eigen::Vector3d(-0.6, 0, 0.8), 0.0},
                                Rectangle(2, -5, 4, 5));  // z = 0.75 x
  const TerrainQuery query(MadeMap({floor, box_top, slope}));
  const auto in = [&](Eigen::Vector3d min, Eigen::Vector3d max) { return query.RegionsIn({min, max}); };
  EXPECT_THAT(in({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}), ElementsAre())
      << "in the hole of the floor, below the top";
  EXPECT_THAT(in({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.5}), ElementsAre(2));
  EXPECT_THAT(in({0.9, -0.1, -0.1}, {1.1, 0.1, 0.1}), ElementsAre(1));
  EXPECT_THAT(in({3.0, 0.0, -0.1}, {3.1, 0.1, 3.0}), ElementsAre(1, 3)) << "inside both, no edge near";
  EXPECT_THAT(in({2.0, 0.0, 2.5}, {2.5, 0.1, 3.0}), ElementsAre()) << "in the slope's box, above its plane";
  EXPECT_THAT(query.RegionsIn({Eigen::Vector3d(-9, -9, -9), Eigen::Vector3d(9, 9, 9)},
                              {TerrainLabel::kRamp, TerrainLabel::kObstacle}),
              ElementsAre(2, 3));
}

TEST(TerrainQueryTest, TheNextMapTakesOverWhatHasNotChangedAndAnswersAsIfMadeAnew) {
  ScatteredTerrain terrain(4);
  const auto first = terrain.Map(100, 2.0);
  const TerrainQuery before(first);
  auto second = std::make_shared<TerrainMap>(*first);
  ++second->seq;
  second->regions.erase(second->regions.begin() + 50);
  for (const int i : {3, 20, 70}) {
    auto changed = terrain.Region(second->regions[static_cast<std::size_t>(i)]->id, 2.0);
    changed->revision = 2;
    second->regions[static_cast<std::size_t>(i)] = changed;
  }
  auto seen_again = std::make_shared<TerrainRegion>(*second->regions[5]);
  seen_again->last_seen = second->t_capture;
  second->regions[5] = seen_again;
  second->regions.push_back(terrain.Region(101, 2.0));
  const TerrainQuery next(second, &before);
  const TerrainQuery anew(second);
  int num_shared = 0;
  for (const TerrainQuery::Entry& entry : next.entries()) {
    const auto* old = before.Find(entry.region->id);
    if (old && old->shape == entry.shape) ++num_shared;
  }
  EXPECT_EQ(num_shared, 96);
  EXPECT_DOUBLE_EQ(next.AgeSeconds(*next.Find(seen_again->id)->region), 0.0);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d xy(terrain.Real(-2, 2), terrain.Real(-2, 2));
    const auto a = next.SupportsAt(xy), b = anew.SupportsAt(xy);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].point_world, b[k].point_world);
  }
}

TEST(TerrainQueryTest, ARegionOfAnotherMapIsNotTakenForTheSame) {
  const auto floor = MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), Rectangle(-1, -1, 1, 1));
  const auto other = MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.3), Rectangle(-1, -1, 1, 1));
  const TerrainQuery before(MadeMap({floor}));
  auto map = MadeMap({other});
  map->map_id = 2;
  EXPECT_DOUBLE_EQ(TerrainQuery(map, &before).SupportAt({0, 0}, -1, 1)->point_world.z(), 0.3);
}

TEST(TerrainQueryTest, KnowsNothingInAnEmptyMap) {
  const TerrainQuery query(MadeMap({}));
  EXPECT_FALSE(query.SupportAt({0, 0}, -1, 1));
  EXPECT_TRUE(query.SupportsAt({0, 0}).empty());
  EXPECT_FALSE(query.NearestFoothold({0, 0, 0}, 1, 1));
  EXPECT_TRUE(query.RegionsIn({Eigen::Vector3d(-9, -9, -9), Eigen::Vector3d(9, 9, 9)}).empty());
  EXPECT_FALSE(query.Heights({}).at(50, 50).known());
}

}  // namespace
}  // namespace terrace
