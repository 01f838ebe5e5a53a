// SPDX-License-Identifier: BSD-3-Clause
#include "tools/result_server.h"

#include <chrono>

#include <gtest/gtest.h>

#include "client/terrace_file.h"
#include "client/terrain_client.h"
#include "test/datasets/temporary_folder.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

ReplayResult FinishedResult() {
  ReplayResult result;
  result.map = ExampleMaps(5).First(40);
  result.map.seq = 0;  // as the file has it
  result.stats.gravity = {Eigen::Vector3d(0.0, 0.02, -1.0).normalized(), 0.01, GravitySource::kImu};
  result.trajectory.push_back({{1600000000000000000}, Eigen::Isometry3d::Identity()});
  result.trajectory.push_back({{1600000001000000000}, Eigen::Isometry3d::Identity()});
  result.trajectory.back().T_world_left.translation() = Eigen::Vector3d(3, 2, 1);
  return result;
}

TEST(ResultServerTest, AClientThatComesLateHasTheMapThePoseAndTheState) {
  lcm::LCM lcm("memq://");
  ResultServer server(&lcm, ServedMap(FinishedResult()));
  while (lcm.handleTimeout(0) > 0) {  // what was sent before the client came
  }
  TerrainClient client(&lcm);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!(client.in_step() && client.newest_pose() && client.Health().state) &&
         std::chrono::steady_clock::now() < patience) {
    lcm.handleTimeout(20);
    server.Tick(std::chrono::steady_clock::now());
  }
  ASSERT_TRUE(client.in_step());
  EXPECT_EQ(client.map()->regions.size(), 40u);
  EXPECT_EQ(client.map()->gravity.source, GravitySource::kImu);
  ASSERT_TRUE(client.newest_pose());
  EXPECT_EQ(client.newest_pose()->t_capture.ns, 1600000001000000000);
  EXPECT_TRUE(client.newest_pose()->T_world_body->translation().isApprox(Eigen::Vector3d(3, 2, 1)));
  EXPECT_EQ(client.Health().state, DaemonState::kRunning);
}

TEST(ResultServerTest, ServesWhatLiesInAFile) {
  const TemporaryFolder folder;
  const TerrainMapPtr map = ServedMap(FinishedResult());
  SaveTerraceFile(folder.path() / "hall.terrace", *map);
  EXPECT_EQ(TerraceFileBytes(*MapToServe(folder.path() / "hall.terrace")), TerraceFileBytes(*map));
}

}  // namespace
}  // namespace terrace
