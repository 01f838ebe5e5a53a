// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_feed.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <terrace/terrain_v1_t.hpp>

#include "client/terrain_follower.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/terrain_codec.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

constexpr std::size_t kRecordHeader = 20;

terrain_v1_t TerrainOf(const ViewBytes& record) {
  const auto message =
      SafeDecode<terrain_v1_t>(record->data() + kRecordHeader, record->size() - kRecordHeader);
  EXPECT_TRUE(message.has_value());
  return message.value_or(terrain_v1_t{});
}

/// Everything that the cursor has to send, and no more than can be right.
std::vector<ViewBytes> Drain(ViewCursor* cursor) {
  std::vector<ViewBytes> records;
  while (ViewBytes record = cursor->Next()) {
    records.push_back(std::move(record));
    if (records.size() > 10000) {
      ADD_FAILURE() << "it never ends";
      break;
    }
  }
  return records;
}

std::string KindsOf(const std::vector<ViewBytes>& records) {
  std::string kinds;
  for (const ViewBytes& record : records) kinds += record->front();
  return kinds;
}

BodyPose PoseAt(double x, int epoch = 0) {
  BodyPose pose;
  pose.epoch = epoch;
  pose.status = TrackingStatus::kTracking;
  pose.T_world_body = Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0));
  return pose;
}

ViewBytes Event(ViewRecordKind kind) { return MakeViewRecord(kind, {}, "content"); }

class ViewFeedTest : public ::testing::Test {
 protected:
  ViewFeedTest() : map_(std::make_shared<TerrainMap>(examples_.First(5))) {}

  /// The next state: one region revised, one gone.
  std::shared_ptr<TerrainMap> Changed(const TerrainMap& before) {
    auto map = std::make_shared<TerrainMap>(before);
    ++map->seq;
    const TerrainRegion& old = *map->regions.front();
    map->regions.front() = examples_.Region(old.id, old.revision + 1);
    map->regions.pop_back();
    return map;
  }

  ExampleMaps examples_{7};
  std::shared_ptr<TerrainMap> map_;
  ViewFeed feed_{{"live", "test"}};
};

TEST_F(ViewFeedTest, SaysFirstWhoSpeaksAndThenTheWholeMap) {
  feed_.TakeMap(map_, {});
  ViewCursor cursor(&feed_);
  const auto records = Drain(&cursor);
  EXPECT_EQ(KindsOf(records), "HT");
  const terrain_v1_t message = TerrainOf(records.back());
  EXPECT_EQ(message.kind, terrain_v1_t::SNAPSHOT);
  EXPECT_EQ(message.regions.size(), map_->regions.size());
}

TEST_F(ViewFeedTest, SendsOnlyWhatHasChangedById) {
  feed_.TakeMap(map_, {});
  ViewCursor cursor(&feed_);
  Drain(&cursor);
  const auto changed = Changed(*map_);
  feed_.TakeMap(changed, {});
  const auto records = Drain(&cursor);
  ASSERT_EQ(KindsOf(records), "T");
  const terrain_v1_t message = TerrainOf(records.front());
  EXPECT_EQ(message.kind, terrain_v1_t::DELTA);
  EXPECT_EQ(message.base_seq, map_->seq);
  ASSERT_EQ(message.regions.size(), 1u);
  EXPECT_EQ(message.regions.front().id, changed->regions.front()->id);
  EXPECT_EQ(message.removed_ids, std::vector<std::int64_t>{map_->regions.back()->id});
  EXPECT_TRUE(Drain(&cursor).empty());
}

TEST_F(ViewFeedTest, GivesASlowBrowserOneDifferenceForAllStatesThatItMissed) {
  feed_.TakeMap(map_, {});
  ViewCursor cursor(&feed_);
  const auto start = Drain(&cursor);
  std::shared_ptr<TerrainMap> map = map_;
  for (int i = 0; i < 3; ++i) feed_.TakeMap(map = Changed(*map), {});
  const auto records = Drain(&cursor);
  ASSERT_EQ(KindsOf(records), "T");
  // A subscriber of the daemon's own messages must come to the same map by them.
  TerrainFollower follower;
  for (const ViewBytes& record : {start.back(), records.front()}) {
    EXPECT_TRUE(follower.Receive(record->data() + kRecordHeader, record->size() - kRecordHeader));
  }
  ASSERT_EQ(follower.map()->regions.size(), map->regions.size());
  EXPECT_EQ(follower.map()->seq, map->seq);
  for (std::size_t i = 0; i < map->regions.size(); ++i) {
    EXPECT_EQ(follower.map()->regions[i]->id, map->regions[i]->id);
    EXPECT_EQ(follower.map()->regions[i]->revision, map->regions[i]->revision);
  }
}

TEST_F(ViewFeedTest, TellsWhenRegionsWereSeenAgainAlsoWhenOthersHaveChangedSince) {
  feed_.TakeMap(map_, {});
  ViewCursor cursor(&feed_);
  Drain(&cursor);
  const auto changed = Changed(*map_);
  auto seen = std::make_shared<TerrainRegion>(*changed->regions[1]);
  seen->last_seen = seen->last_seen + std::chrono::seconds(1);
  changed->regions[1] = seen;
  feed_.TakeMap(changed, {});
  const auto records = Drain(&cursor);
  ASSERT_EQ(KindsOf(records), "TT");
  EXPECT_EQ(TerrainOf(records[0]).kind, terrain_v1_t::DELTA);
  EXPECT_EQ(TerrainOf(records[1]).kind, terrain_v1_t::SEEN);
  EXPECT_EQ(TerrainOf(records[1]).seen_ids, std::vector<std::int64_t>{seen->id});
}

TEST_F(ViewFeedTest, KeepsABoundedNumberOfMessagesAndCountsWhatABrowserMissed) {
  ViewCursor cursor(&feed_);
  Drain(&cursor);
  for (int i = 0; i < 1000; ++i) feed_.TakeEvent(Event(ViewRecordKind::kStatus));
  const auto records = Drain(&cursor);
  EXPECT_LT(records.size(), 300u);
  EXPECT_EQ(records.size() + static_cast<std::size_t>(cursor.num_skipped()), 1000u);
}

TEST_F(ViewFeedTest, TellsTheWaySoFarToWhoComesLaterAndForgetsThatOfAnotherWorld) {
  for (int i = 0; i < 100; ++i) feed_.TakePose(PoseAt(0.01 * i), Event(ViewRecordKind::kPose));
  ViewCursor late(&feed_);
  const auto num_poses = KindsOf(Drain(&late)).size() - 1;
  EXPECT_GE(num_poses, 15u);  // a metre, one every five centimetres
  EXPECT_LE(num_poses, 21u);
  feed_.TakePose(PoseAt(5.0, 1), Event(ViewRecordKind::kPose));
  ViewCursor later(&feed_);
  EXPECT_EQ(KindsOf(Drain(&later)), "HP");
}

TEST_F(ViewFeedTest, ThinsALongWayAndKeepsItsLength) {
  for (int i = 0; i < 50000; ++i) feed_.TakePose(PoseAt(0.1 * i), Event(ViewRecordKind::kPose));
  ViewCursor late(&feed_);
  EXPECT_LT(Drain(&late).size(), 4002u);
}

TEST_F(ViewFeedTest, SendsTheNewestImageAloneAndOnlyToWhoWantsIt) {
  ViewCursor without(&feed_);
  ViewCursor with(&feed_);
  ViewSlots wants;
  wants.Add(ViewSlot::kImage);
  with.SetWants(wants);
  Drain(&without);
  Drain(&with);
  feed_.Take(ViewSlot::kImage, Event(ViewRecordKind::kImage));
  const ViewBytes newest = Event(ViewRecordKind::kImage);
  feed_.Take(ViewSlot::kImage, newest);
  EXPECT_TRUE(Drain(&without).empty());
  EXPECT_EQ(Drain(&with), std::vector<ViewBytes>{newest});
}

TEST_F(ViewFeedTest, SendsAPlanAtOnceAndWhatCostsMostLast) {
  ViewCursor cursor(&feed_);
  ViewSlots wants;
  for (const ViewSlot slot : {ViewSlot::kImage, ViewSlot::kDisparity, ViewSlot::kCells}) wants.Add(slot);
  cursor.SetWants(wants);
  Drain(&cursor);
  feed_.Take(ViewSlot::kPoints, Event(ViewRecordKind::kPoints));  // which it does not want
  feed_.Take(ViewSlot::kCells, Event(ViewRecordKind::kCells));
  feed_.Take(ViewSlot::kDisparity, Event(ViewRecordKind::kDisparity));
  feed_.TakeMap(map_, {});
  feed_.TakePose(PoseAt(0.0), Event(ViewRecordKind::kPose));
  feed_.Take(ViewSlot::kPlan, Event(ViewRecordKind::kPlan));
  EXPECT_EQ(KindsOf(Drain(&cursor)), "GPTDV");
  // Who comes later is told the plan, too.
  ViewCursor late(&feed_);
  EXPECT_EQ(KindsOf(Drain(&late)), "HPGT");
}

TEST_F(ViewFeedTest, SendsANewMapWhole) {
  feed_.TakeMap(map_, {});
  ViewCursor cursor(&feed_);
  Drain(&cursor);
  auto other = std::make_shared<TerrainMap>(*map_);
  ++other->map_id;
  feed_.TakeMap(other, {});
  const auto records = Drain(&cursor);
  ASSERT_EQ(KindsOf(records), "T");
  EXPECT_EQ(TerrainOf(records.front()).kind, terrain_v1_t::SNAPSHOT);
}

}  // namespace
}  // namespace terrace
