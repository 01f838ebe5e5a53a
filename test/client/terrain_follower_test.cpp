// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_follower.h"

#include <algorithm>
#include <deque>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcmtypes/terrain_codec.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Small, so that snapshots and deltas come in several parts.
constexpr std::size_t kPartBytes = 1000;

std::vector<Bytes> Encoded(const std::vector<terrain_v1_t>& messages) {
  std::vector<Bytes> all;
  for (const terrain_v1_t& message : messages) {
    Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    all.push_back(std::move(bytes));
  }
  return all;
}

std::vector<Bytes> Snapshot(const TerrainMap& map, std::size_t part_bytes = kPartBytes) {
  return Encoded(SnapshotMessages(map, part_bytes));
}
std::vector<Bytes> Delta(const TerrainMap& base, const TerrainMap& map, std::size_t part_bytes = kPartBytes) {
  return Encoded(DeltaMessages(base, map, part_bytes));
}

bool ReceiveAll(TerrainFollower* follower, const std::vector<Bytes>& messages) {
  bool changed = false;
  for (const Bytes& bytes : messages) changed |= follower->Receive(bytes.data(), bytes.size());
  return changed;
}

/// Every bit of a map, as one comparable thing.
std::vector<Bytes> Contents(const TerrainMapPtr& map) { return map ? Snapshot(*map) : std::vector<Bytes>(); }

/// What a subscriber has that got this state in one undisturbed snapshot.
std::vector<Bytes> ContentsAfterSnapshotOf(const TerrainMap& map) {
  TerrainFollower follower;
  EXPECT_TRUE(ReceiveAll(&follower, Snapshot(map)));
  return Contents(follower.map());
}

TEST(TerrainFollowerTest, HasNoMapBeforeTheFirstSnapshotAndAsksForOneThoughItHasHeardNothing) {
  ExampleMaps maps(1);
  const TerrainMap first = maps.First(20);
  TerrainFollower follower;
  EXPECT_EQ(follower.map(), nullptr);
  EXPECT_FALSE(follower.in_step());
  const TerrainFollower::Time start{std::chrono::seconds(10)};
  const auto repair = follower.TakeRepair(start);
  ASSERT_TRUE(repair);
  EXPECT_EQ(repair->have_seq, -1);
  EXPECT_FALSE(follower.TakeRepair(start + std::chrono::milliseconds(20))) << "has just been asked";
  EXPECT_TRUE(follower.TakeRepair(start + std::chrono::milliseconds(120))) << "nobody has answered";
  EXPECT_FALSE(ReceiveAll(&follower, Delta(first, maps.Next(first))));
  EXPECT_EQ(follower.map(), nullptr);
  EXPECT_TRUE(ReceiveAll(&follower, Snapshot(first)));
  EXPECT_TRUE(follower.in_step());
  EXPECT_EQ(follower.map()->seq, first.seq + 1) << "the delta that came early fits now";
}

TEST(TerrainFollowerTest, FollowsDeltasAndSharesWhatHasNotChanged) {
  ExampleMaps maps(2);
  const TerrainMap first = maps.First(30);
  TerrainMap second = first;
  ++second.seq;
  second.regions[3] = maps.Region(4, 2);
  second.regions.pop_back();
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(first));
  const TerrainMapPtr before = follower.map();
  EXPECT_TRUE(ReceiveAll(&follower, Delta(first, second)));
  EXPECT_EQ(follower.map()->regions.size(), 29u);
  EXPECT_EQ(follower.map()->regions[0], before->regions[0]);
  EXPECT_NE(follower.map()->regions[3], before->regions[3]);
  EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(second));
}

TEST(TerrainFollowerTest, TakesPartsInAnyOrderAndTwice) {
  const TerrainMap map = ExampleMaps(3).First(40);
  std::vector<Bytes> parts = Snapshot(map);
  ASSERT_GT(parts.size(), 3u);
  parts.insert(parts.end(), parts.begin(), parts.end());
  std::shuffle(parts.begin(), parts.end(), std::mt19937(3));
  TerrainFollower follower;
  EXPECT_TRUE(ReceiveAll(&follower, parts));
  EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(map));
}

TEST(TerrainFollowerTest, NamesThePartsThatItLacksAndOfALostDeltaTheStateBefore) {
  ExampleMaps maps(4);
  const TerrainMap first = maps.First(20);
  const TerrainMap second = maps.Next(first);  // never arrives
  const TerrainMap third = maps.Next(second);
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(first));
  std::vector<Bytes> parts = Delta(second, third);
  ASSERT_GT(parts.size(), 2u);
  parts.erase(parts.begin() + 1);
  ReceiveAll(&follower, parts);
  EXPECT_EQ(follower.map()->seq, first.seq) << "a delta without its base changes nothing";
  EXPECT_FALSE(follower.in_step());
  EXPECT_FALSE(follower.TakeRepair(std::chrono::steady_clock::now())) << "it may be under way";
  const auto repair = follower.TakeRepair(std::chrono::steady_clock::now() + std::chrono::seconds(1));
  ASSERT_TRUE(repair);
  EXPECT_EQ(repair->map_id, first.map_id);
  EXPECT_EQ(repair->have_seq, first.seq);
  ASSERT_EQ(repair->n_steps, 1) << "the lost delta is not known, and therefore not named";
  EXPECT_EQ(repair->steps[0].kind, terrain_v1_t::DELTA);
  EXPECT_EQ(repair->steps[0].seq, third.seq);
  EXPECT_THAT(repair->steps[0].missing, testing::ElementsAre(1));
  ReceiveAll(&follower, Delta(first, second));
  ReceiveAll(&follower, Delta(second, third));
  EXPECT_TRUE(follower.in_step());
  EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(third));
}

TEST(TerrainFollowerTest, CatchesUpWithASnapshot) {
  ExampleMaps maps(4);
  TerrainMap map = maps.First(20);
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(map));
  for (int i = 0; i < 3; ++i) map = maps.Next(map);
  ReceiveAll(&follower, Snapshot(map));
  EXPECT_TRUE(follower.in_step());
  EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(map));
}

TEST(TerrainFollowerTest, ForgetsTheOldMapWhenANewOneBeginsAndIgnoresItsLateMessages) {
  ExampleMaps maps(5);
  const TerrainMap old = maps.First(10);
  const TerrainMap older_than_late = maps.Next(old);
  TerrainMap fresh = maps.First(3);
  fresh.map_id = 2;
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(old));
  ReceiveAll(&follower, Snapshot(fresh));
  EXPECT_FALSE(ReceiveAll(&follower, Snapshot(older_than_late)));
  EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(fresh));
}

TEST(TerrainFollowerTest, LearnsThatRegionsWereSeenAgainWithoutANewState) {
  const TerrainMap first = ExampleMaps(12).First(4);
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(first));
  const TerrainMapPtr before = follower.map();
  TerrainMap later = first;
  later.t_capture.ns += 3'000'000'000;
  later.T_world_left.translation().x() += 1.0;
  const Timestamp seen = later.t_capture - std::chrono::milliseconds(40);
  const SeenRegion list[] = {{2, seen}, {99, seen}};
  EXPECT_TRUE(ReceiveAll(&follower, Encoded(SeenMessages(later, std::nullopt, list))));
  EXPECT_EQ(follower.map()->seq, first.seq);
  EXPECT_EQ(follower.map()->t_capture, later.t_capture);
  EXPECT_EQ(follower.map()->T_world_left.translation(), later.T_world_left.translation());
  EXPECT_EQ(follower.map()->regions[1]->last_seen, seen);
  EXPECT_EQ(follower.map()->regions[1]->revision, before->regions[1]->revision);
  EXPECT_EQ(follower.map()->regions[0], before->regions[0]);
  EXPECT_EQ(follower.map()->staircases.size(), before->staircases.size());
}

TEST(TerrainFollowerTest, HearsOfANewerStateWithoutHavingIt) {
  ExampleMaps maps(13);
  const TerrainMap first = maps.First(4);
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(first));
  EXPECT_TRUE(follower.in_step());
  ReceiveAll(&follower, Encoded(SeenMessages(maps.Next(first), std::nullopt, {})));
  EXPECT_FALSE(follower.in_step());
}

TEST(TerrainFollowerTest, CountsWhatIsNoMessageAndKeepsItsMap) {
  const TerrainMap map = ExampleMaps(6).First(5);
  TerrainFollower follower;
  ReceiveAll(&follower, Snapshot(map));
  const char rubbish[] = "rubbish that is no message";
  EXPECT_FALSE(follower.Receive(rubbish, sizeof(rubbish)));
  std::vector<terrain_v1_t> bad = SnapshotMessages(map, 100'000);
  bad[0].seq += 1;
  bad[0].regions[0].source = 100;
  EXPECT_FALSE(ReceiveAll(&follower, Encoded(bad)));
  bad[0].part = 5;
  EXPECT_FALSE(ReceiveAll(&follower, Encoded(bad)));
  EXPECT_EQ(follower.num_bad_messages(), 3);
  EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(map));
}

TEST(TerrainFollowerTest, KeepsLittleOfWhatNeverBecomesComplete) {
  TerrainFollower follower;
  terrain_v1_t part{};
  part.frame_id = "world";
  part.n_parts = 1000;
  for (int i = 0; i < 3000; ++i) {
    part.seq = i;
    part.part = i % 999;
    ReceiveAll(&follower, Encoded({part}));
  }
  EXPECT_EQ(follower.map(), nullptr);
}

/// A network that loses, doubles and reorders, seeded.
class BadNetwork {
 public:
  BadNetwork(double loss, unsigned seed) : loss_(loss), random_(seed) {}

  void Send(const std::vector<Bytes>& messages) {
    for (const Bytes& bytes : messages) {
      if (Chance(loss_)) continue;
      queue_.push_back(bytes);
      if (Chance(0.1)) queue_.push_back(bytes);
    }
  }

  /// Delivers all but a few, in an order of its own.
  void Deliver(TerrainFollower* follower, std::size_t keep_back) {
    while (queue_.size() > keep_back) {
      const std::size_t reach = std::min<std::size_t>(queue_.size(), 5);
      const auto picked = queue_.begin() + static_cast<std::ptrdiff_t>(random_() % reach);
      follower->Receive(picked->data(), picked->size());
      queue_.erase(picked);
    }
  }

 private:
  bool Chance(double p) { return std::uniform_real_distribution<>(0.0, 1.0)(random_) < p; }

  const double loss_;
  std::mt19937 random_;
  std::deque<Bytes> queue_;
};

TEST(TerrainFollowerTest, EndsWithTheSameMapHoweverLateAndLossyItListened) {
  // Nothing is repaired here, so that a state must be able to come through whole: in one or two parts.
  constexpr std::size_t kLargeParts = 6000;
  for (unsigned seed = 0; seed < 60; ++seed) {
    ExampleMaps maps(seed);
    BadNetwork network(0.1 * (seed % 6), seed);
    TerrainFollower follower;
    TerrainMap map = maps.First(12);
    const int listens_from = static_cast<int>(seed % 10);
    int num_states_seen = 0;
    for (int step = 0; step < 40; ++step) {
      TerrainMap next = maps.Next(map);
      const bool cleared = step == 20 && seed % 2 == 0;
      if (cleared) {
        next = maps.First(4);
        next.map_id = map.map_id + 1;
      }
      if (step >= listens_from) {
        if (!cleared) network.Send(Delta(map, next, kLargeParts));
        // Now and then by itself, and when it is needed.
        if (cleared || step % 15 == 0 || !follower.in_step()) network.Send(Snapshot(next, kLargeParts));
        const TerrainMapPtr before = follower.map();
        network.Deliver(&follower, 3);
        if (follower.map() != before) ++num_states_seen;
      }
      map = next;
    }
    EXPECT_GT(num_states_seen, 0) << "seed " << seed;
    // The world stands still now; snapshots go on coming.
    for (int i = 0; i < 100; ++i) {
      network.Send(Snapshot(map, kLargeParts));
      network.Deliver(&follower, 0);
    }
    ASSERT_NE(follower.map(), nullptr);
    EXPECT_EQ(Contents(follower.map()), ContentsAfterSnapshotOf(map)) << "seed " << seed;
    EXPECT_TRUE(follower.in_step()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace terrace
