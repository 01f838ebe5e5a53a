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
