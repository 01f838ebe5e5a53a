// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/loaded_map.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "client/terrain_query.h"
#include "core/map_difference.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

constexpr double kPi = M_PI;

/// A mapper's map that a test changes frame by frame, with a robot that stands at the world's origin.
class LoadedMapTest : public ::testing::Test {
 protected:
  MapChange Frame(std::vector<std::shared_ptr<const TerrainRegion>> regions,
                  std::vector<Staircase> staircases = {}) {
    auto map = MadeMap(std::move(regions));
    map->map_id = map_id_;
    map->epoch = epoch_;
    map->seq = ++seq_;
    map->staircases = std::move(staircases);
    MapChange change;
    change.before = own_;
    change.map = map;
    if (own_) static_cast<MapDifference&>(change) = DifferenceBetween(*own_, *map);
    own_ = map;
    PoseEstimate pose;
    pose.t_capture = map->t_capture;
    pose.status = TrackingStatus::kTracking;
    pose.trusted = true;
    pose.epoch = epoch_;
    pose.T_world_left.linear() = LevelLeft();
    return loaded_.Join(change, pose, nullptr);
  }

  /// The camera looks along x: then the body is turned as the world.
  static Eigen::Matrix3d LevelLeft() {
    Eigen::Matrix3d R;
    R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return R;
  }

  static std::shared_ptr<TerrainRegion> Floor(std::int64_t id, double x0, double y0, double x1, double y1,
                                              double z = 0.0) {
    return MadeRegion(id, TerrainLabel::kWalkway, LevelAt(z), Rectangle(x0, y0, x1, y1), {}, EdgeKind::kDrop);
  }

  static int NumGroundsAt(const TerrainMapPtr& map, double x, double y) {
    return static_cast<int>(TerrainQuery(map).SupportsAt({x, y}).size());
  }

  TerrainMapPtr own_;
  std::int64_t map_id_ = 1;
  int epoch_ = 0;
  std::int64_t seq_ = 0;
  LoadedMap loaded_{StereoCamera{}, std::nullopt};
};

TEST_F(LoadedMapTest, LeavesTheMapAloneWhileNobodySaysWhereTheRobotIs) {
  EXPECT_FALSE(loaded_.transform());
  loaded_.Load({MadeMap({Floor(7, 0, 0, 1, 1)}), {}}, "hall.terrace", std::nullopt);
  const MapChange change = Frame({Floor(1, 0, 0, 1, 1)});
  EXPECT_EQ(change.map, own_);
  ASSERT_TRUE(loaded_.transform());
  EXPECT_EQ(loaded_.transform()->placing, MapPlacing::kNotFound);
  EXPECT_FALSE(loaded_.transform()->reason.empty());
  ASSERT_NE(loaded_.unplaced(), nullptr);
  EXPECT_EQ(loaded_.unplaced()->regions.front()->id, 7);
}

TEST_F(LoadedMapTest, PutsTheLoadedMapWhereTheRobotIsInIt) {
  auto saved = MadeMap({Floor(7, 2, 3, 4, 4, 1.0)});
  loaded_.Load({saved, {}}, "hall.terrace", BodyInMap{{2, 3, 1.5}, 0.5 * kPi});
  const MapChange change = Frame({});
  ASSERT_EQ(change.map->regions.size(), 1u);
  const TerrainRegion& region = *change.map->regions.front();
  EXPECT_EQ(region.id, 7);
  EXPECT_NEAR(region.plane_world.offset_m, -0.5, 1e-12);
  // The robot looks along the map's y: what lies 2 m along the map's x is 2 m to its right.
  const Ring expected{{0, 0, -0.5}, {0, -2, -0.5}, {1, -2, -0.5}, {1, 0, -0.5}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((region.outline_world[i] - expected[i]).norm(), 1e-12) << i;
  const auto transform = loaded_.transform();
  ASSERT_TRUE(transform);
  EXPECT_EQ(transform->placing, MapPlacing::kGiven);
  EXPECT_LT((transform->T_map_world * expected[1] - saved->regions[0]->outline_world[1]).norm(), 1e-12);
  EXPECT_EQ(loaded_.unplaced(), nullptr);
  EXPECT_NE(change.map->map_id, own_->map_id) << "another map has begun";
}

TEST_F(LoadedMapTest, ShowsNoGroundTwiceAndLosesNoneWhateverIsSeen) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(0.0, 4.0), size(0.3, 1.5), height(-0.02, 0.02);
  loaded_.Load({MadeMap({Floor(3, 0, 0, 3, 2), Floor(9, 3, 0, 5, 2, 0.15)}), {}}, "hall.terrace",
               BodyInMap{{0, 0, 0}, 0.0});
  // Floors that are seen one after the other, none over another.
  std::vector<std::shared_ptr<const TerrainRegion>> seen;
  std::int64_t last_seq = -1;
  for (int frame = 0; frame < 12; ++frame) {
    const double x = 0.4 * frame - 0.2, y = at(random) * 0.3;
    seen.push_back(
        Floor(frame + 1, x, y, x + 0.4, y + size(random), (x < 2.8 ? 0.0 : 0.15) + height(random)));
    const MapChange change = Frame(seen);
    EXPECT_GT(change.map->seq, last_seq);
    last_seq = change.map->seq;
    const TerrainQuery query(change.map);
    for (int i = 0; i < 1500; ++i) {
      const Eigen::Vector2d xy(1.3 * at(random) - 0.1, 0.55 * at(random) - 0.1);
      const auto supports = query.SupportsAt(xy);
      const bool in_seen = std::any_of(seen.begin(), seen.end(), [&](const auto& region) {
        return RegionShape(*region).polygon().Contains(RegionShape(*region).ToPlane({xy.x(), xy.y(), 0}));
      });
      const bool in_loaded = xy.x() > 0 && xy.x() < 5 && xy.y() > 0 && xy.y() < 2;
      if (in_seen && supports.size() == 2) {
        // Where a floor of 0 m reaches under the one of 0.15 m, both stand.
        EXPECT_NEAR(supports[0].point_world.z() - supports[1].point_world.z(), 0.15, 0.03) << xy.transpose();
        continue;
      }
      EXPECT_LE(supports.size(), 1u) << xy.transpose();
      const bool nothing = !in_loaded && !in_seen;
      EXPECT_TRUE(!in_seen || supports.size() == 1) << xy.transpose();
      EXPECT_TRUE(!nothing || supports.empty()) << xy.transpose();
    }
  }
  // Only ragged rests may be lost.
  const TerrainMapPtr map = Frame(seen).map;
  const TerrainQuery query(map);
  int known = 0, all = 0;
  for (double x = 0.01; x < 5.0; x += 0.02) {
    for (double y = 0.01; y < 2.0; y += 0.02, ++all)
      if (!query.SupportsAt({x, y}).empty()) ++known;
  }
  EXPECT_GT(known, 0.98 * all);
}

TEST_F(LoadedMapTest, GivesNothingBackWhenWhatWasSeenGoes) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 2)}), {}}, "hall.terrace", BodyInMap{});
  EXPECT_EQ(NumGroundsAt(Frame({}).map, 1.5, 1.0), 1);
  const TerrainMapPtr map = Frame({Floor(1, 1, -1, 3, 3)}).map;
  EXPECT_EQ(NumGroundsAt(map, 1.5, 1.0), 1);
  EXPECT_EQ(map->regions.front()->id, 3);
  EXPECT_NEAR(map->regions.front()->area_m2, 2.0, 1e-5);
  const MapChange after = Frame({});
  EXPECT_EQ(NumGroundsAt(after.map, 1.5, 1.0), 0) << "it was seen that it is gone";
  EXPECT_EQ(NumGroundsAt(after.map, 0.5, 1.0), 1);
}

TEST_F(LoadedMapTest, KeepsAKerbBesideTheStreetThatIsSeen) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 2, 0.1)}), {}}, "hall.terrace", BodyInMap{});
  Frame({});
  EXPECT_EQ(NumGroundsAt(Frame({Floor(1, -1, -1, 3, 3, 0.0)}).map, 1.0, 1.0), 2);
}

TEST_F(LoadedMapTest, SaysJoinsWhereWhatWasSeenGoesOn) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 1)}), {}}, "hall.terrace", BodyInMap{});
  Frame({});
  const TerrainMapPtr map = Frame({Floor(1, 1, -1, 3, 3)}).map;
  const TerrainRegion& left = *map->regions.front();
  for (std::size_t i = 0; i < left.outline_world.size(); ++i) {
    const Eigen::Vector3d middle =
        0.5 * (left.outline_world[i] + left.outline_world[(i + 1) % left.outline_world.size()]);
    EXPECT_EQ(left.edges[i].kind, std::abs(middle.x() - 1.0) < 1e-6 ? EdgeKind::kJoins : EdgeKind::kDrop);
  }
}

TEST_F(LoadedMapTest, WaitsWithWhatIsNotDecided) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 2)}), {}}, "hall.terrace", BodyInMap{});
  auto undecided = Floor(1, 0.5, 0.5, 1.5, 1.5, 0.01);
  undecided->label = TerrainLabel::kUnknown;
  TerrainMapPtr map = Frame({undecided}).map;
  ASSERT_EQ(map->regions.size(), 1u);
  EXPECT_EQ(map->regions.front()->label, TerrainLabel::kWalkway);
  auto decided = std::make_shared<TerrainRegion>(*undecided);
  decided->label = TerrainLabel::kObstacle;
  ++decided->revision;
  map = Frame({decided}).map;
  ASSERT_EQ(map->regions.size(), 2u);
  EXPECT_EQ(TerrainQuery(map).SupportsAt({1.0, 1.0}).front().label, TerrainLabel::kObstacle);
}

Staircase Flight(std::int64_t id, int num_risers, const Eigen::Vector3d& base) {
  Staircase flight;
  flight.id = id;
  flight.num_risers = num_risers;
  flight.num_treads = num_risers - 1;
  flight.riser_m = 0.17;
  flight.tread_m = 0.28;
  flight.width_m = 1.0;
  const Eigen::Vector3d aside(0, 0.5, 0);
  const Eigen::Vector3d head = base + Eigen::Vector3d(0.28 * (num_risers - 1), 0, 0.17 * num_risers);
  flight.foot_edge_world = {base + aside, base - aside};
  flight.head_edge_world = {head + aside, head - aside};
  flight.confidence = 0.9;
  return flight;
}

std::shared_ptr<TerrainRegion> Tread(std::int64_t id, std::int64_t staircase_id, int step, double x,
                                     double z) {
  auto tread = MadeRegion(id, TerrainLabel::kStairTread, LevelAt(z), Rectangle(x, -0.5, x + 0.28, 0.5), {},
                          EdgeKind::kDrop);
  tread->staircase_id = staircase_id;
  tread->step_index = step;
  return tread;
}

TEST_F(LoadedMapTest, CountsTheStepsOfAFlightThatIsSeenInPartByTheWholeOne) {
  auto saved =
      MadeMap({Tread(11, 4, 1, 1.0, 0.17), Tread(12, 4, 2, 1.28, 0.34), Tread(13, 4, 3, 1.56, 0.51)});
  saved->staircases = {Flight(4, 4, {1, 0, 0})};
  loaded_.Load({saved, {}}, "hall.terrace", BodyInMap{});
  Frame({});
  // Its first riser is the second one of the flight.
  const TerrainMapPtr map = Frame({Tread(1, 1, 1, 1.29, 0.345)}, {Flight(1, 2, {1.29, 0.02, 0.175})}).map;
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].id, 4);
  EXPECT_EQ(map->staircases[0].num_risers, 4);
  ASSERT_EQ(map->regions.size(), 3u) << "the tread that is seen is there once";
  for (const auto& region : map->regions) {
    EXPECT_EQ(region->staircase_id, 4);
    EXPECT_EQ(region->step_index, static_cast<int>(std::lround(region->centroid_world.z() / 0.17)));
  }
  EXPECT_EQ(map->staircases[0].region_ids.size(), 3u);
}

TEST_F(LoadedMapTest, LetsAFlightGrowBelowAndAboveTheLoadedOne) {
  auto saved = MadeMap({Tread(11, 4, 1, 1.0, 0.17)});
  saved->staircases = {Flight(4, 2, {1, 0, 0})};
  loaded_.Load({saved, {}}, "hall.terrace", BodyInMap{});
  Frame({});
  const TerrainMapPtr map =
      Frame({Tread(1, 1, 1, 0.72, 0.0), Tread(2, 1, 3, 1.28, 0.34)}, {Flight(1, 4, {0.72, 0.0, -0.17})}).map;
  ASSERT_EQ(map->staircases.size(), 1u);
  EXPECT_EQ(map->staircases[0].id, 4);
  EXPECT_EQ(map->staircases[0].num_risers, 4);
  EXPECT_NEAR(map->staircases[0].base_world().z(), -0.17, 1e-9);
  for (const auto& region : map->regions)
    EXPECT_EQ(region->step_index, static_cast<int>(std::lround(region->centroid_world.z() / 0.17)) + 1);
}

TEST_F(LoadedMapTest, KeepsAnotherFlightApart) {
  auto saved = MadeMap({Tread(11, 4, 1, 1.0, 0.17)});
  saved->staircases = {Flight(4, 2, {1, 0, 0})};
  loaded_.Load({saved, {}}, "hall.terrace", BodyInMap{});
  Frame({});
  const TerrainMapPtr map = Frame({Tread(1, 1, 1, 4.0, 0.17)}, {Flight(1, 2, {4, 0, 0})}).map;
  EXPECT_EQ(map->staircases.size(), 2u);
}

/// An upright face at x = 3 or y = 2, seen from within.
std::shared_ptr<TerrainRegion> WallOf(std::int64_t id, const Eigen::Vector3d& normal, double offset_m) {
  auto wall = MadeRegion(id, TerrainLabel::kWall, LevelAt(0.0), Rectangle(0, 0, 1, 1));
  const Eigen::Vector3d along = Eigen::Vector3d::UnitZ().cross(normal), foot = offset_m * normal;
  const Eigen::Vector3d up = 2.0 * Eigen::Vector3d::UnitZ();
  wall->plane_world = {normal, offset_m};
  wall->outline_world = {foot - 2 * along, foot + 2 * along, foot + 2 * along + up, foot - 2 * along + up};
  wall->centroid_world = foot + 0.5 * up;
  wall->area_m2 = 8.0;
  wall->plane_covariance = Eigen::Vector3d(1e-6, 1e-6, 4e-6).asDiagonal();
  return wall;
}

TEST_F(LoadedMapTest, MovesOntoWhatIsSeenOnceThatFixesThePlaceAndSaysSo) {
  const auto room = [] {
    std::vector<std::shared_ptr<const TerrainRegion>> regions;
    auto floor = Floor(1, -2, -2, 3, 2);
    floor->plane_covariance = Eigen::Vector3d(1e-6, 1e-6, 4e-6).asDiagonal();
    regions.push_back(floor);
    regions.push_back(WallOf(2, -Eigen::Vector3d::UnitX(), -3.0));
    regions.push_back(WallOf(3, -Eigen::Vector3d::UnitY(), -2.0));
    return regions;
  };
  // The robot stands at the map's origin, and somebody says 5 cm and 1.5 deg beside it.
  loaded_.Load({MadeMap(room()), {}}, "hall.terrace", BodyInMap{{0.04, -0.03, 0.02}, 0.026});
  const std::int64_t given_id = Frame(room()).map->map_id;
  EXPECT_EQ(loaded_.transform()->placing, MapPlacing::kGiven);
  TerrainMapPtr map;
  for (int i = 0; i < 20; ++i) map = Frame(room()).map;
  const auto transform = loaded_.transform();
  ASSERT_EQ(transform->placing, MapPlacing::kConfirmed) << transform->reason;
  EXPECT_TRUE(transform->reason.empty());
  EXPECT_LT(transform->T_map_world.translation().norm(), 0.01);
  EXPECT_LT(Eigen::AngleAxisd(transform->T_map_world.linear()).angle(), 0.005);
  EXPECT_LT(transform->covariance(3, 3), 1e-3);
  EXPECT_GT(map->map_id, given_id) << "the loaded regions have moved";
  EXPECT_EQ(map->regions.size(), 3u) << "all of it is seen";
}

TEST_F(LoadedMapTest, ForgetsTheLoadedMapWhenTheMapIsToBeginAnew) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 2)}), {}}, "hall.terrace", BodyInMap{});
  const std::int64_t joint_id = Frame({}).map->map_id;
  ++map_id_;
  const MapChange change = Frame({});
  EXPECT_TRUE(change.map->regions.empty());
  EXPECT_GT(change.map->map_id, joint_id);
  EXPECT_FALSE(loaded_.transform());
}

TEST_F(LoadedMapTest, SaysThatItDoesNotKnowWhereItLiesInAnotherWorld) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 2)}), {}}, "hall.terrace", BodyInMap{});
  const std::int64_t joint_id = Frame({}).map->map_id;
  ++map_id_;
  ++epoch_;
  const MapChange change = Frame({Floor(1, 0, 0, 1, 1)});
  EXPECT_EQ(change.map->regions.size(), 1u);
  EXPECT_GT(change.map->map_id, joint_id);
  ASSERT_TRUE(loaded_.transform());
  EXPECT_EQ(loaded_.transform()->placing, MapPlacing::kNotFound);
  EXPECT_NE(loaded_.transform()->reason.find("lost"), std::string::npos);
  EXPECT_NE(loaded_.unplaced(), nullptr);
}

TEST_F(LoadedMapTest, ExplainsUnderTheIdsOfTheJointMap) {
  loaded_.Load({MadeMap({Floor(3, 0, 0, 2, 2)}), {}}, "hall.terrace", BodyInMap{});
  const TerrainMapPtr map = Frame({Floor(1, 4, 0, 5, 1)}).map;
  ASSERT_EQ(map->regions.size(), 2u);
  EXPECT_FALSE(loaded_.OwnId(3));
  EXPECT_EQ(loaded_.OwnId(map->regions[1]->id), 1);
}

TEST_F(LoadedMapTest, IsAsUncertainAboutHeightsAsItsPlace) {
  // Errors drawn from the place's covariance move a region as far as the region's own covariance says.
  Gravity gravity;
  gravity.sigma_rad = 0.01;
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.translation() = Eigen::Vector3d(1, -2, 0.5);
  const MapPlace place = PlaceOf({{3, 1, 0.4}, 0.7}, T_world_body, gravity, gravity);
  auto region = MadeRegion(3, TerrainLabel::kWalkway, {Eigen::Vector3d(0.1, 0.2, 1).normalized(), 0.3},
                           Rectangle(4, 4, 6, 7));
  region->plane_covariance = 1e-16 * Eigen::Matrix3d::Identity();
  const TerrainRegion placed = Placed(*region, place);
  const RegionShape shape(placed);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const Matrix6d root = place.covariance.llt().matrixL();
  const Eigen::Vector3d corner = placed.outline_world[2];
  double sum = 0.0;
  constexpr int kNum = 4000;
  for (int i = 0; i < kNum; ++i) {
    Vector6d draw;
    for (int k = 0; k < 6; ++k) draw[k] = normal(random);
    const Vector6d error = root * draw;
    Eigen::Isometry3d T_error = Eigen::Isometry3d::Identity();
    if (error.head<3>().norm() > 0)
      T_error.linear() =
          Eigen::AngleAxisd(error.head<3>().norm(), error.head<3>().normalized()).toRotationMatrix();
    T_error.translation() = error.tail<3>();
    MapPlace other = place;
    other.T_map_world = place.T_map_world * T_error;
    const TerrainRegion moved = Placed(*region, other);
    const double z = RegionShape(moved).HeightAt(corner.head<2>());
    sum += (z - corner.z()) * (z - corner.z());
  }
  const double sigma_m = shape.SigmaHeight(shape.ToPlane(corner));
  EXPECT_NEAR(sigma_m / std::sqrt(sum / kNum), 1.0, 0.05);
}

}  // namespace
}  // namespace terrace
