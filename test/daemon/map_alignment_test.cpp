// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/map_alignment.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "test/client/made_terrain.h"

namespace terrace {
namespace {

std::shared_ptr<TerrainRegion> UprightFace(std::int64_t id, const Eigen::Vector3d& normal, double offset_m,
                                           double from, double to, double top) {
  auto wall = MadeRegion(id, TerrainLabel::kWall, LevelAt(0.0), Rectangle(0, 0, 1, 1));
  const Eigen::Vector3d along = Eigen::Vector3d::UnitZ().cross(normal);
  const Eigen::Vector3d foot = offset_m * normal;
  wall->plane_world = {normal, offset_m};
  wall->outline_world = {foot + from * along, foot + to * along,
                         foot + to * along + top * Eigen::Vector3d::UnitZ(),
                         foot + from * along + top * Eigen::Vector3d::UnitZ()};
  wall->centroid_world = foot + 0.5 * (from + to) * along + 0.5 * top * Eigen::Vector3d::UnitZ();
  wall->area_m2 = (to - from) * top;
  return wall;
}

/// A room with a table, as it was when the map was saved.
std::vector<TerrainRegion> Room(bool with_walls) {
  std::vector<TerrainRegion> room{
      *MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(-3, -2, 3, 2)),
      *MadeRegion(2, TerrainLabel::kObstacle, LevelAt(0.7), Rectangle(1, 0.5, 2, 1.5))};
  if (with_walls) {
    room.push_back(*UprightFace(3, -Eigen::Vector3d::UnitX(), -3.0, -2.0, 2.0, 2.0));
    room.push_back(*UprightFace(4, -Eigen::Vector3d::UnitY(), -2.0, -3.0, 3.0, 2.0));
  }
  return room;
}

Eigen::Isometry3d Turned(const Vector6d& error) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (error.head<3>().norm() > 0.0)
    T.linear() = Eigen::AngleAxisd(error.head<3>().norm(), error.head<3>().normalized()).toRotationMatrix();
  T.translation() = error.tail<3>();
  return T;
}

MapPlace PriorAt(const Eigen::Isometry3d& T_map_world) {
  MapPlace prior;
  prior.T_map_world = T_map_world;
  prior.covariance.diagonal() << 1e-4, 1e-4, 1.2e-3, 2.5e-3, 2.5e-3, 2.5e-3;
  return prior;
}

/// What is seen of a room that lies at T_map_world: planes drawn from their covariances.
TerrainMapPtr Seen(const std::vector<TerrainRegion>& room, const Eigen::Isometry3d& T_map_world,
                   std::mt19937* random) {
  std::normal_distribution<double> normal;
  auto map = MadeMap({});
  for (const TerrainRegion& region : room) {
    MapPlace exact;
    exact.T_map_world = T_map_world;
    auto seen = std::make_shared<TerrainRegion>(Placed(region, exact));
    const PlaneAxes axes = AxesOf(seen->plane_world.normal);
    const Eigen::Vector3d draw(normal(*random), normal(*random), normal(*random));
    const Eigen::Vector3d error = seen->plane_covariance.llt().matrixL() * draw;
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(error.x(), axes.x) * Eigen::AngleAxisd(error.y(), axes.y)).toRotationMatrix();
    const Eigen::Vector3d center = seen->centroid_world + error.z() * seen->plane_world.normal;
    for (Eigen::Vector3d& p : seen->outline_world) p = center + turn * (p - seen->centroid_world);
    seen->centroid_world = center;
    seen->plane_world.normal = turn * seen->plane_world.normal;
    seen->plane_world.offset_m = seen->plane_world.normal.dot(center);
    map->regions.push_back(seen);
  }
  return map;
}

std::vector<TerrainRegion> WithSigmas(std::vector<TerrainRegion> room, double tilt_rad, double offset_m) {
  for (TerrainRegion& region : room)
    region.plane_covariance =
        Eigen::Vector3d(tilt_rad * tilt_rad, tilt_rad * tilt_rad, offset_m * offset_m).asDiagonal();
  return room;
}

TEST(MapAlignmentTest, FindsThePlaceWithinItsOwnSigmas) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  constexpr int kRooms = 40;
  double sum_nees = 0.0;
  int num_confirmed = 0;
  Eigen::Isometry3d T_map_world = Eigen::Isometry3d::Identity();
  T_map_world.linear() = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_map_world.translation() = Eigen::Vector3d(0.3, -0.4, 0.1);
  for (int i = 0; i < kRooms; ++i) {
    const MapPlace at_truth = PriorAt(T_map_world);
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = std::sqrt(at_truth.covariance(k, k)) * normal(random);
    const auto room = WithSigmas(Room(true), 0.003, 0.004);
    const MapAlignment found = Align(room, PriorAt(T_map_world * Turned(error)),
                                     *Seen(room, T_map_world, &random), Eigen::Vector3d::Zero());
    const Eigen::Isometry3d left = found.place.T_map_world.inverse() * T_map_world;
    Vector6d off;
    off << Eigen::AngleAxisd(left.linear()).angle() * Eigen::AngleAxisd(left.linear()).axis(),
        left.translation();
    EXPECT_LT(off.tail<3>().norm(), 0.04) << i;
    sum_nees += off.dot(found.place.covariance.inverse() * off);
    num_confirmed += found.confirmed ? 1 : 0;
  }
  // Six numbers, and the covariance counts noise of the saved map that is not drawn here: less than six.
  EXPECT_LT(sum_nees / kRooms, 7.0);
  EXPECT_GT(sum_nees / kRooms, 0.5);
  EXPECT_GT(num_confirmed, kRooms * 8 / 10);
}

/// A floor and a wall, and the first steps of a flight away from the robot.
std::vector<TerrainRegion> Stairs() {
  std::vector<TerrainRegion> stairs{
      *MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(-1, -1, 2, 1)),
      *UprightFace(2, -Eigen::Vector3d::UnitY(), -1.0, -2.0, 4.0, 2.0)};
  for (int step = 0; step < 2; ++step) {
    const double x = 2.0 + 0.29 * step, z = 0.16 * (step + 1);
    auto riser = *UprightFace(20 + step, -Eigen::Vector3d::UnitX(), -x, -0.75, 0.75, 0.16);
    riser.label = TerrainLabel::kStairRiser;
    for (Eigen::Vector3d& p : riser.outline_world) p.z() += z - 0.16;
    riser.centroid_world.z() += z - 0.16;
    stairs.push_back(riser);
    stairs.push_back(
        *MadeRegion(10 + step, TerrainLabel::kStairTread, LevelAt(z), Rectangle(x, -0.75, x + 0.29, 0.75)));
  }
  return WithSigmas(stairs, 0.01, 0.004);
}

/// As the left camera's views know it.
MapPlace RecognisedAt(const Eigen::Isometry3d& T_map_world) {
  MapPlace prior = PriorAt(T_map_world);
  prior.covariance.diagonal() << Eigen::Vector3d::Constant(1.5e-5), Eigen::Vector3d::Constant(1e-4);
  return prior;
}

/// How far the middle of the flight lies from where it is, in the root of the mean square of many draws.
double StairsOff_m(const std::vector<TerrainRegion>& saved, const std::vector<TerrainRegion>& shown,
                   bool aligned) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  const Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d middle(3.0, 0.0, 0.5);
  constexpr int kDraws = 30;
  double squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    Vector6d error;
    for (int k = 0; k < 6; ++k) error[k] = std::sqrt(RecognisedAt(truth).covariance(k, k)) * normal(random);
    const MapPlace prior = RecognisedAt(truth * Turned(error));
    const MapPlace place =
        aligned ? Align(saved, prior, *Seen(shown, truth, &random), Eigen::Vector3d::Zero()).place : prior;
    squares += (place.T_map_world * middle - middle).squaredNorm();
  }
  return std::sqrt(squares / kDraws);
}

TEST(MapAlignmentTest, MakesARecognisedPlaceMoreExactOnStairs) {
  const double before_m = StairsOff_m(Stairs(), Stairs(), false);
  EXPECT_LT(StairsOff_m(Stairs(), Stairs(), true), 0.6 * before_m);
}

TEST(MapAlignmentTest, IsNotLedAstrayBySlantsOverStepsThatAreTooFarToBeToldApart) {
  std::vector<TerrainRegion> saved = Stairs(), shown = Stairs();
  // Each run lays another plane over the upper steps, and believes it by a degree and 3 mm.
  const auto slant = [](double slope_rad, double z, double min_y, double max_y) {
    const Eigen::Vector3d normal(-std::sin(slope_rad), 0.0, std::cos(slope_rad));
    const Plane plane{normal, normal.dot(Eigen::Vector3d(3.0, 0.0, z))};
    auto region = *MadeRegion(40, TerrainLabel::kUnknown, plane, Rectangle(2.6, min_y, 3.6, max_y));
    region.plane_covariance = Eigen::Vector3d(2e-4, 2e-4, 9e-6).asDiagonal();
    return region;
  };
  saved.push_back(slant(0.56, 0.75, -0.7, 0.0));
  saved.push_back(slant(0.56, 0.75, 0.0, 0.7));
  shown.push_back(slant(0.50, 0.72, -0.7, 0.7));
  EXPECT_LT(StairsOff_m(saved, shown, true), 1.05 * StairsOff_m(Stairs(), Stairs(), true));
}

TEST(MapAlignmentTest, WeighsASurfaceThatWasTurnedLess) {
  std::vector<TerrainRegion> saved = Stairs(), shown = Stairs();
  // A board that leans on the lower steps, and has been leant anew.
  const auto board = [](double slope_rad) {
    const Eigen::Vector3d normal(-std::sin(slope_rad), 0.0, std::cos(slope_rad));
    auto region =
        *MadeRegion(40, TerrainLabel::kObstacle, {normal, normal.dot(Eigen::Vector3d(1.6, 0.0, 0.3))},
                    Rectangle(1.2, -0.9, 2.0, -0.2));
    region.plane_covariance = Eigen::Vector3d(1e-6, 1e-6, 4e-6).asDiagonal();
    return region;
  };
  saved.push_back(board(0.55));
  shown.push_back(board(0.45));
  EXPECT_LT(StairsOff_m(saved, shown, true), 1.3 * StairsOff_m(Stairs(), Stairs(), true));
}

TEST(MapAlignmentTest, LeavesThePlaceAlongAFloorToThePrior) {
  std::mt19937 random(4);
  const auto room = WithSigmas(Room(false), 0.002, 0.002);
  const Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  Vector6d error = Vector6d::Zero();
  error << 0.01, -0.01, 0.02, 0.04, -0.03, 0.05;
  const MapPlace prior = PriorAt(truth * Turned(error));
  const MapAlignment found = Align(room, prior, *Seen(room, truth, &random), Eigen::Vector3d::Zero());
  EXPECT_NEAR(found.place.T_map_world.translation().z(), 0.0, 0.01);
  EXPECT_NEAR(found.place.T_map_world.translation().x(), prior.T_map_world.translation().x(), 0.01);
  EXPECT_GT(found.place.covariance(3, 3), 0.9 * prior.covariance(3, 3));
  EXPECT_FALSE(found.confirmed);
  EXPECT_NE(found.reason.find("too little"), std::string::npos) << found.reason;
}

TEST(MapAlignmentTest, DoesNotConfirmAPlaceThatWhatIsSeenContradicts) {
  std::mt19937 random(5);
  const auto room = WithSigmas(Room(true), 0.002, 0.002);
  const Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  for (const Eigen::Vector3d& wrong : {Eigen::Vector3d(1.0, 0, 0), Eigen::Vector3d(0.25, 0, 0),
                                       Eigen::Vector3d(0, 0.28, 0), Eigen::Vector3d(0, 0, 0.17)}) {
    Vector6d error = Vector6d::Zero();
    error.tail<3>() = wrong;
    const MapAlignment found =
        Align(room, PriorAt(truth * Turned(error)), *Seen(room, truth, &random), Eigen::Vector3d::Zero());
    EXPECT_FALSE(found.confirmed) << wrong.transpose();
    EXPECT_FALSE(found.reason.empty());
  }
}

TEST(MapAlignmentTest, SaysThatNothingIsSeenOfTheMap) {
  const MapAlignment found =
      Align(Room(true), PriorAt(Eigen::Isometry3d::Identity()), *MadeMap({}), {0, 0, 0});
  EXPECT_FALSE(found.confirmed);
  EXPECT_NE(found.reason.find("nothing"), std::string::npos);
}

}  // namespace
}  // namespace terrace
