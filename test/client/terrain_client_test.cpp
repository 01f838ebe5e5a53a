// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_client.h"

#include <chrono>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/terrain_codec.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

void HandleAll(lcm::LCM* lcm) {
  while (lcm->handleTimeout(0) > 0) {
  }
}

TEST(TerrainClientTest, AsksUntilItHasAMapThoughItHearsNothingAndFollowsFromThere) {
  lcm::LCM lcm("memq://");
  int num_requests = 0;
  lcm.subscribeFunction(
      "TERRACE_REPAIR",
      +[](const lcm::ReceiveBuffer* buffer, const std::string&, int* count) {
        const auto repair = SafeDecode<terrain_repair_v1_t>(buffer->data, buffer->data_size);
        if (repair && repair->have_seq == -1) ++*count;
      },
      &num_requests);
  TerrainClient client(&lcm);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (num_requests < 3 && std::chrono::steady_clock::now() < patience) lcm.handleTimeout(50);
  EXPECT_EQ(num_requests, 3);
  EXPECT_EQ(client.map(), nullptr);
  EXPECT_FALSE(client.in_step());

  ExampleMaps maps(1);
  const TerrainMap first = maps.First(10);
  const TerrainMap second = maps.Next(first);
  for (const terrain_v1_t& message : SnapshotMessages(first)) lcm.publish("TERRACE_TERRAIN", &message);
  for (const terrain_v1_t& message : DeltaMessages(first, second)) lcm.publish("TERRACE_TERRAIN", &message);
  HandleAll(&lcm);
  ASSERT_NE(client.map(), nullptr);
  EXPECT_EQ(client.map()->seq, second.seq);
  EXPECT_EQ(client.map()->regions.size(), second.regions.size());
  EXPECT_TRUE(client.in_step());
}

TEST(TerrainClientTest, TellsWhatEachStateOfTheMapChanged) {
  lcm::LCM lcm("memq://");
  TerrainClient client(&lcm);
  std::vector<std::pair<MapDifference, TerrainMapPtr>> told;
  client.OnChange(
      [&](const MapDifference& change, const TerrainMapPtr& map) { told.emplace_back(change, map); });
  ExampleMaps maps(2);
  const TerrainMap first = maps.First(10);
  TerrainMap second = first;
  ++second.seq;
  second.regions[3] = maps.Region(4, 2);
  second.regions.pop_back();
  TerrainMap other = maps.First(3);
  other.map_id = 2;
  for (const terrain_v1_t& message : SnapshotMessages(first)) lcm.publish("TERRACE_TERRAIN", &message);
  for (const terrain_v1_t& message : DeltaMessages(first, second)) lcm.publish("TERRACE_TERRAIN", &message);
  for (const terrain_v1_t& message : SnapshotMessages(other)) lcm.publish("TERRACE_TERRAIN", &message);
  HandleAll(&lcm);
  ASSERT_EQ(told.size(), 4u);
  EXPECT_EQ(told[0].first.added.size(), 10u);
  EXPECT_EQ(told[1].first.revised, std::vector<std::int64_t>{4});
  EXPECT_EQ(told[1].first.removed, std::vector<std::int64_t>{10});
  EXPECT_EQ(told[1].second->seq, second.seq);
  EXPECT_EQ(told[2].first.removed.size(), 9u);
  EXPECT_EQ(told[2].second, nullptr) << "another map begins";
  EXPECT_EQ(told[3].first.added.size(), 3u);
  EXPECT_EQ(told[3].second->map_id, 2);
}

TEST(TerrainClientTest, HealthTellsADaemonThatLivesFromSilenceAndCountsMessagesOfAWrongType) {
  lcm::LCM lcm("memq://");
  TerrainClient client(&lcm);
  EXPECT_FALSE(client.Health().silence_s);
  EXPECT_FALSE(client.Health().image_age_s);
  EXPECT_FALSE(client.Health().state);
  Status status;
  status.state = DaemonState::kDegraded;
  status.reason = "few images";
  const status_v1_t status_message = ToMessage(status);
  lcm.publish("TERRACE_STATUS", &status_message);
  lcm.publish("TERRACE_TERRAIN", &status_message);
  lcm.publish("TERRACE_POSE_STATE", &status_message);
  lcm.publish("TERRACE_POSE_STATE", &status_message);
  HandleAll(&lcm);
  ClientHealth health = client.Health();
  ASSERT_TRUE(health.silence_s);
  EXPECT_LT(*health.silence_s, 60.0);
  EXPECT_EQ(health.state, DaemonState::kDegraded);
  EXPECT_EQ(health.reason, "few images");
  EXPECT_EQ(health.num_bad_terrain, 1);
  EXPECT_EQ(health.num_bad_pose, 2);
  EXPECT_EQ(health.num_bad_status, 0);
  EXPECT_FALSE(health.tracking);

  BodyPose pose;
  pose.t_capture = {std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count() -
                    5'000'000'000};
  pose.status = TrackingStatus::kLost;
  pose.reason = "too dark";
  const pose_v1_t pose_message = ToMessage(pose);
  lcm.publish("TERRACE_POSE_STATE", &pose_message);
  HandleAll(&lcm);
  health = client.Health();
  EXPECT_EQ(health.tracking, TrackingStatus::kLost);
  EXPECT_EQ(health.reason, "too dark");
  ASSERT_TRUE(health.image_age_s);
  EXPECT_GE(*health.image_age_s, 5.0);
  EXPECT_LT(*health.image_age_s, 65.0);
}

}  // namespace
}  // namespace terrace
