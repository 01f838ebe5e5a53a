// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/terrain_publisher.h"

#include <memory>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/terrain_client.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

using testing::ElementsAre;

constexpr int kSnapshot = terrain_v1_t::SNAPSHOT;
constexpr int kDelta = terrain_v1_t::DELTA;

/// What a subscriber hears.
class Ear {
 public:
  explicit Ear(lcm::LCM* lcm) : lcm_(lcm) {
    const ChannelConfig channels;
    Subscribe<&Ear::OnTerrain>(lcm_, channels.terrain, this)->setQueueCapacity(4000);
    Subscribe<&Ear::OnPose>(lcm_, channels.pose, this);
    Subscribe<&Ear::OnUpdate>(lcm_, channels.odometry, this);
    Subscribe<&Ear::OnState>(lcm_, channels.pose_state, this)->setQueueCapacity(100);
  }

  void HandleAll() {
    while (lcm_->handleTimeout(0) > 0) {
    }
  }
  std::vector<int> TakeKinds() { return std::exchange(kinds, {}); }

  std::vector<int> kinds;
  std::vector<pose_t> poses;
  std::vector<update_t> updates;
  std::vector<pose_v1_t> states;

 private:
  void OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto message = SafeDecode<terrain_v1_t>(buffer->data, buffer->data_size);
    ASSERT_TRUE(message);
    EXPECT_LE(buffer->data_size, kMaxTerrainMessageBytes);
    if (message->part == 0 && message->kind != terrain_v1_t::SEEN) kinds.push_back(message->kind);
  }
  void OnState(const lcm::ReceiveBuffer* buffer, const std::string&) {
    states.push_back(*SafeDecode<pose_v1_t>(buffer->data, buffer->data_size));
  }
  void OnPose(const lcm::ReceiveBuffer* buffer, const std::string&) {
    poses.push_back(*SafeDecode<pose_t>(buffer->data, buffer->data_size));
  }
  void OnUpdate(const lcm::ReceiveBuffer* buffer, const std::string&) {
    updates.push_back(*SafeDecode<update_t>(buffer->data, buffer->data_size));
  }

  lcm::LCM* lcm_;
};

class TerrainPublisherTest : public testing::Test {
 protected:
  /// As if this map came out of the frame it was made from.
  void Publish(const TerrainMap& map, TrackingStatus status = TrackingStatus::kTracking) {
    PoseEstimate pose;
    pose.t_capture = map.t_capture;
    pose.status = status;
    pose.T_world_left = map.T_world_left;
    publisher_.PublishPose(pose);
    MapChange change;
    change.map = std::make_shared<const TerrainMap>(map);
    publisher_.PublishTerrain(change);
    ear_.HandleAll();
  }

  lcm::LCM lcm_{"memq://"};
  Ear ear_{&lcm_};
  TerrainPublisher publisher_{&lcm_, {}, std::nullopt, 60.0};
  ExampleMaps maps_{1};
};

TEST_F(TerrainPublisherTest, SendsASnapshotFirstThenDeltas) {
  TerrainClient client(&lcm_);
  TerrainMap map = maps_.First(40);
  Publish(map);
  EXPECT_THAT(ear_.TakeKinds(), ElementsAre(kSnapshot));
  for (int frame = 1; frame <= 15; ++frame) {
    map = maps_.Next(map);
    Publish(map);
    EXPECT_EQ(ear_.TakeKinds(), std::vector<int>{kDelta});
    ASSERT_NE(client.map(), nullptr);
    EXPECT_EQ(client.map()->seq, map.seq);
    EXPECT_EQ(client.map()->regions.size(), map.regions.size());
  }
}

TEST_F(TerrainPublisherTest, SendsNoTerrainWhenNothingHasChangedButAlwaysTheMotion) {
  const TerrainMap map = maps_.First(3);
  for (int i = 0; i < 3; ++i) Publish(map);
  EXPECT_THAT(ear_.kinds, ElementsAre(kSnapshot));
  EXPECT_EQ(ear_.updates.size(), 3u);
  EXPECT_EQ(ear_.poses.size(), 3u);
  EXPECT_EQ(ear_.states.size(), 3u);
}

TEST_F(TerrainPublisherTest, SendsNoPoseWhileLostAndSaysSoInTheMotion) {
  const TerrainMap map = maps_.First(3);
  Publish(map);
  Publish(map, TrackingStatus::kLost);
  EXPECT_EQ(ear_.poses.size(), 1u);
  ASSERT_EQ(ear_.updates.size(), 2u);
  EXPECT_EQ(ear_.updates[1].estimate_status, update_t::NO_DATA);
  ASSERT_EQ(ear_.states.size(), 2u) << "for every frame";
  EXPECT_EQ(ear_.states[1].status, pose_v1_t::LOST);
  EXPECT_TRUE(FromMessage(ear_.states[0])->T_world_body);
  EXPECT_FALSE(FromMessage(ear_.states[1])->T_world_body);
}

TEST_F(TerrainPublisherTest, SendsTheMapWholeWhenAskedAndWhenANewOneBegins) {
  EXPECT_FALSE(publisher_.SendSnapshot()) << "there is none yet";
  TerrainMap map = maps_.First(3);
  Publish(map);
  EXPECT_TRUE(publisher_.SendSnapshot());
  EXPECT_FALSE(publisher_.sending_snapshot()) << "a small map goes at once";
  Status status;
  publisher_.Describe(&status);
  EXPECT_EQ(status.map_seq, map.seq);
  EXPECT_GT(status.map_id, 0);
  map = maps_.Next(map);
  ++map.map_id;
  Publish(map);
  EXPECT_THAT(ear_.kinds, ElementsAre(kSnapshot, kSnapshot, kSnapshot));
}

TEST_F(TerrainPublisherTest, GivesTheBodyXForwardAndZUpWhenNoMountingIsKnown) {
  TerrainMap map = maps_.First(1);
  map.T_world_left.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along the world's x
  Publish(map);
  ASSERT_EQ(ear_.poses.size(), 1u);
  EXPECT_NEAR(ear_.poses[0].orientation[0], 1.0, 1e-12);
}

}  // namespace
}  // namespace terrace
