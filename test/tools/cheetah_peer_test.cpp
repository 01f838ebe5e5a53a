// SPDX-License-Identifier: BSD-3-Clause
#include "tools/cheetah_peer.h"

#include <chrono>
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"
#include "test/client/made_terrain.h"
#include "tools/result_server.h"

namespace terrace {
namespace {

/// What the walker hears.
class Walker {
 public:
  explicit Walker(lcm::LCM* lcm) {
    Subscribe<&Walker::OnHeights>(lcm, "local_heightmap", this);
    Subscribe<&Walker::OnTraversability>(lcm, "traversability", this);
    Subscribe<&Walker::OnLocalization>(lcm, "global_to_robot", this);
  }

  std::optional<heightmap_t> heights;
  std::optional<traversability_map_t> traversability;
  std::optional<localization_lcmt> localization;

 private:
  void OnHeights(const lcm::ReceiveBuffer* buffer, const std::string&) {
    heights = SafeDecode<heightmap_t>(buffer->data, buffer->data_size);
  }
  void OnTraversability(const lcm::ReceiveBuffer* buffer, const std::string&) {
    traversability = SafeDecode<traversability_map_t>(buffer->data, buffer->data_size);
  }
  void OnLocalization(const lcm::ReceiveBuffer* buffer, const std::string&) {
    localization = SafeDecode<localization_lcmt>(buffer->data, buffer->data_size);
  }
};

constexpr double kFloor = -0.4;  // below the body, where the world begins
constexpr double kTop = 0.12;    // of the step over the floor

/// A floor with a hole beside the robot and a step before it; further to the left nothing has been seen.
TerrainMapPtr Place() {
  auto map =
      MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(kFloor), Rectangle(-1, -1, 0.3, 0.5),
                          {Rectangle(-0.3, -0.45, 0.0, -0.3)}, EdgeKind::kDrop),
               MadeRegion(2, TerrainLabel::kObstacle, LevelAt(kFloor + kTop), Rectangle(0.3, -1, 1, 0.5))});
  Eigen::Matrix3d level;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  map->T_world_left.linear() = level;
  map->T_world_left.translation() = Eigen::Vector3d(0.1, 0.05, 0.0);
  map->T_body_left = Eigen::Isometry3d::Identity();
  map->T_body_left->linear() = level;
  return map;
}

int CellOf(double from_robot_m) { return 50 + static_cast<int>(std::lround(from_robot_m / 0.015)); }

TEST(CheetahPeerTest, TheWalkerHearsWhereTheGroundIsAndWhereNothingIsKnown) {
  lcm::LCM bus("memq://"), to_walker("memq://");
  Walker walker(&to_walker);
  ResultServer server(&bus, Place());
  TerrainClient client(&bus);
  CheetahPeer peer(&client, &to_walker, FootSpec{}, 50.0);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!(walker.localization && walker.heights && walker.traversability && peer.problem().empty()) &&
         std::chrono::steady_clock::now() < patience) {
    bus.handleTimeout(5);
    server.Tick(std::chrono::steady_clock::now());
    peer.Tick(std::chrono::steady_clock::now());
    walker.heights.reset();
    while (to_walker.handleTimeout(0) > 0) {
    }
  }
  ASSERT_TRUE(walker.localization && walker.heights && walker.traversability) << peer.problem();
  // The ground under the robot is at zero, and the body 0.4 m above it.
  EXPECT_NEAR(walker.localization->xyz[0], 0.1, 1e-6);
  EXPECT_NEAR(walker.localization->xyz[1], 0.05, 1e-6);
  EXPECT_NEAR(walker.localization->xyz[2], 0.4, 1e-6);
  for (const float angle : walker.localization->rpy) EXPECT_NEAR(angle, 0.0, 1e-6);
  EXPECT_NEAR(walker.heights->robot_loc[2], 0.4, 1e-9);
  const auto height = [&](double x, double y) {
    return walker.heights->map[CellOf(x - 0.1)][CellOf(y - 0.05)];
  };
  const auto stand = [&](double x, double y) {
    return walker.traversability->map[CellOf(x - 0.1)][CellOf(y - 0.05)];
  };
  EXPECT_NEAR(height(0.1, 0.05), 0.0, 1e-6);
  EXPECT_EQ(stand(0.1, 0.05), kMayStand);
  EXPECT_NEAR(height(0.5, 0.05), kTop, 1e-6);
  EXPECT_EQ(stand(0.5, 0.05), kMayNotStand) << "an obstacle";
  EXPECT_EQ(stand(0.27, 0.05), kMayNotStand) << "3 cm before a drop";
  EXPECT_EQ(stand(-0.15, -0.38), kUnseenGround) << "the hole";
  EXPECT_EQ(stand(0.1, 0.6), kUnseenGround) << "never seen";
  EXPECT_NEAR(height(0.1, 0.6), 0.0, 1e-6) << "no obstacle is made up";
}

TEST(CheetahPeerTest, EveryCellThatMayBeStoodOnKeepsTheSoleOnItsRegion) {
  ScatteredTerrain terrain(12);
  const TerrainQuery query(terrain.Map(60, 0.8, 10));
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.translation() = Eigen::Vector3d(0.2, -0.1, 5.0);
  FootSpec foot;
  const CheetahMaps maps = CheetahMapsOf(query, T_world_body, 0.0, foot);
  int num_stands = 0;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const Eigen::Vector2d xy(0.2 + 0.015 * (i - 50), -0.1 + 0.015 * (j - 50));
      const auto supports = query.SupportsAt(xy);
      const int stand = maps.traversability.map[i][j];
      EXPECT_EQ(stand == kUnseenGround, supports.empty());
      if (stand != kMayStand) continue;
      ++num_stands;
      EXPECT_TRUE(kWalkableLabels.Has(supports.front().label));
      EXPECT_GE(supports.front().edge_distance_m, foot.radius_m - 1e-5);
      EXPECT_NEAR(maps.heights.map[i][j], supports.front().point_world.z(), 1e-5);
    }
  }
  EXPECT_GT(num_stands, 100);
}

TEST(CheetahPeerTest, TellsTheWalkerThatNothingIsKnownWhileNobodySpeaks) {
  lcm::LCM bus("memq://"), to_walker("memq://");
  Walker walker(&to_walker);
  const TerrainClient client(&bus);
  CheetahPeer peer(&client, &to_walker, FootSpec{}, 10.0);
  peer.Tick(std::chrono::steady_clock::now());
  while (to_walker.handleTimeout(0) > 0) {
  }
  EXPECT_FALSE(peer.problem().empty());
  EXPECT_FALSE(walker.localization);
  ASSERT_TRUE(walker.traversability);
  for (const auto& row : walker.traversability->map)
    for (const int cell : row) EXPECT_EQ(cell, kUnseenGround);
}

TEST(CheetahPeerTest, TurnsAnglesAsTheWalkerDoes) {
  const double roll = 0.1, pitch = -0.2, yaw = 2.5;
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.linear() =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  const localization_lcmt message = CheetahLocalization(T_world_body, 0.0);
  EXPECT_NEAR(message.rpy[0], roll, 1e-6);
  EXPECT_NEAR(message.rpy[1], pitch, 1e-6);
  EXPECT_NEAR(message.rpy[2], yaw, 1e-6);
}

}  // namespace
}  // namespace terrace
