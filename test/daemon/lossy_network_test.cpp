// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/terrain_follower.h"
#include "daemon/terrain_sender.h"
#include "lcmtypes/safe_decode.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Time = TerrainSender::Time;
using Bytes = TerrainSender::Bytes;

template <typename Message>
Bytes Encoded(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Carries messages one way as a network with an MTU of 1,500 bytes does: in fragments, each lost with the
/// same probability, a message with any of its fragments; the rest a little later.
class Relay {
 public:
  Relay(double loss, unsigned seed) : loss_(loss), random_(seed) {}

  void Send(Bytes message, Time now) {
    constexpr std::size_t kFragmentBytes = 1500 - 28;  // less the headers of IP and UDP
    constexpr std::size_t kLcmHeaderBytes = 8 + 16;    // magic, number and channel
    num_bytes_ += message.size() + kLcmHeaderBytes;
    const std::size_t num_fragments =
        (message.size() + kLcmHeaderBytes + kFragmentBytes - 1) / kFragmentBytes;
    for (std::size_t i = 0; i < num_fragments; ++i) {
      if (std::uniform_real_distribution<>(0.0, 1.0)(random_) < loss_) return;
    }
    const auto delay = microseconds(std::uniform_int_distribution<>(500, 3000)(random_));
    under_way_.emplace(now + delay, std::move(message));
  }

  void Deliver(Time now, const std::function<void(const Bytes&)>& receive) {
    while (!under_way_.empty() && under_way_.begin()->first <= now) {
      const Bytes message = std::move(under_way_.begin()->second);
      under_way_.erase(under_way_.begin());
      receive(message);
    }
  }

  std::size_t num_bytes() const { return num_bytes_; }

 private:
  const double loss_;
  std::mt19937 random_;
  std::multimap<Time, Bytes> under_way_;
  std::size_t num_bytes_ = 0;
};

/// A sender and a follower with a relay each way, on a clock of their own.
class LossyBus {
 public:
  LossyBus(double loss, unsigned seed)
      : to_follower_(loss, seed),
        to_sender_(loss, seed + 1000),
        sender_(std::nullopt, std::chrono::seconds(60), 0) {}

  void Publish(const TerrainMap& map) {
    published_.push_back({now_, map.map_id, map.seq});
    MapChange change;
    change.map = std::make_shared<const TerrainMap>(map);
    Send(sender_.Update(change, now_));
  }

  /// Lets time pass; the share of it during which the follower held a state published at most 0.3 s ago.
  void Run(milliseconds duration) {
    constexpr milliseconds kStep(1), kTick(20), kAsk(10);
    for (const Time end = now_ + duration; now_ < end; now_ += kStep) {
      to_follower_.Deliver(now_, [&](const Bytes& m) { follower_.Receive(m.data(), m.size(), now_); });
      to_sender_.Deliver(now_, [&](const Bytes& m) {
        Send(sender_.Answer(*SafeDecode<terrain_repair_v1_t>(m.data(), m.size()), now_));
      });
      const milliseconds since = std::chrono::duration_cast<milliseconds>(now_.time_since_epoch());
      if (since.count() % kTick.count() == 0) Send(sender_.Tick(now_));
      if (since.count() % kAsk.count() == 0) {
        if (const auto repair = follower_.TakeRepair(now_)) to_sender_.Send(Encoded(*repair), now_);
      }
      num_in_step_ += InStep();
      ++num_steps_;
    }
  }

  double share_in_step() const { return static_cast<double>(num_in_step_) / static_cast<double>(num_steps_); }
  void ForgetShare() { num_in_step_ = num_steps_ = 0; }
  const TerrainFollower& follower() const { return follower_; }
  std::size_t num_terrain_bytes() const { return to_follower_.num_bytes(); }
  std::size_t max_message_bytes() const { return max_message_bytes_; }

 private:
  struct Published {
    Time t;
    std::int64_t map_id;
    std::int64_t seq;
  };

  void Send(const std::vector<TerrainSender::Packet>& packets) {
    for (const TerrainSender::Packet& packet : packets) {
      max_message_bytes_ = std::max(max_message_bytes_, packet->size());
      to_follower_.Send(*packet, now_);
    }
  }

  /// True when a state as new as the one that stood 0.3 s ago is held.
  bool InStep() const {
    constexpr milliseconds kFresh(300);
    const Published* stood = nullptr;
    for (const Published& state : published_)
      if (state.t <= now_ - kFresh) stood = &state;
    if (stood == nullptr) return true;  // nothing is that old yet
    const TerrainMapPtr& map = follower_.map();
    return map && (map->map_id > stood->map_id || (map->map_id == stood->map_id && map->seq >= stood->seq));
  }

  Time now_{std::chrono::seconds(1000)};
  Relay to_follower_;
  Relay to_sender_;
  TerrainSender sender_;
  TerrainFollower follower_;
  std::vector<Published> published_;
  std::size_t max_message_bytes_ = 0;
  std::int64_t num_in_step_ = 0;
  std::int64_t num_steps_ = 0;
};

std::vector<Bytes> Contents(const TerrainMap& map) {
  std::vector<Bytes> all;
  for (const terrain_v1_t& message : SnapshotMessages(map)) all.push_back(Encoded(message));
  return all;
}

/// What a subscriber has that got this state undisturbed.
std::vector<Bytes> ContentsAfterSnapshotOf(const TerrainMap& map) {
  TerrainFollower follower;
  for (const Bytes& message : Contents(map)) follower.Receive(message.data(), message.size());
  return follower.map() ? Contents(*follower.map()) : std::vector<Bytes>();
}

/// Half a minute of 15 frames a second, each changing a fifth of 40 regions, the client there from the start.
double ShareInStep(double loss, unsigned seed) {
  LossyBus bus(loss, seed);
  ExampleMaps maps(seed);
  TerrainMap map = maps.First(40);
  for (int frame = 0; frame < 450; ++frame) {
    bus.Publish(map);
    bus.Run(milliseconds(frame % 3 == 0 ? 66 : 67));
    if (map.regions.size() > 60) map.regions.resize(40);
    map = maps.Next(map);
  }
  EXPECT_LE(bus.max_message_bytes(), kMaxTerrainMessageBytes);
  return bus.share_in_step();
}

TEST(LossyNetworkTest, KeepsAClientInStepThoughOneFragmentInAHundredIsLost) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const double share = ShareInStep(0.01, seed);
    std::printf("1 %% lost, seed %u: in step %.2f %% of the time\n", seed, 100.0 * share);
    EXPECT_GE(share, 0.995);
  }
}

TEST(LossyNetworkTest, KeepsAClientInStepThoughOneFragmentInTenIsLost) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const double share = ShareInStep(0.10, seed);
    std::printf("10 %% lost, seed %u: in step %.2f %% of the time\n", seed, 100.0 * share);
    EXPECT_GE(share, 0.97);
  }
}

TEST(LossyNetworkTest, KeepsAClientInStepThoughThreeFragmentsInTenAreLost) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const double share = ShareInStep(0.30, seed);
    std::printf("30 %% lost, seed %u: in step %.2f %% of the time\n", seed, 100.0 * share);
    EXPECT_GE(share, 0.85);
  }
}

TEST(LossyNetworkTest, EndsWithTheSameMapSoonAfterTheLastChange) {
  const std::map<double, milliseconds> patience = {
      {0.01, milliseconds(1000)}, {0.10, milliseconds(2000)}, {0.30, milliseconds(5000)}};
  for (const auto& [loss, time] : patience) {
    for (unsigned seed = 0; seed < 5; ++seed) {
      LossyBus bus(loss, seed);
      ExampleMaps maps(seed);
      TerrainMap map = maps.First(60);
      for (int frame = 0; frame < 20; ++frame) {
        bus.Publish(map);
        bus.Run(milliseconds(67));
        if (frame < 19) map = maps.Next(map);
      }
      bus.Run(time);
      ASSERT_NE(bus.follower().map(), nullptr);
      EXPECT_TRUE(bus.follower().in_step());
      EXPECT_EQ(Contents(*bus.follower().map()), ContentsAfterSnapshotOf(map)) << loss << ", seed " << seed;
    }
  }
}

TEST(LossyNetworkTest, GivesAMapToWhoComesLateAndFollowsWhenANewOneBegins) {
  LossyBus bus(0.3, 7);
  ExampleMaps maps(7);
  TerrainMap map = maps.First(200);
  bus.Publish(map);
  bus.Run(milliseconds(1500));
  ASSERT_NE(bus.follower().map(), nullptr);
  EXPECT_EQ(bus.follower().map()->regions.size(), 200u);
  map = maps.First(150);
  map.map_id = 2;
  bus.Publish(map);
  bus.Run(milliseconds(1500));
  EXPECT_EQ(bus.follower().map()->map_id, 2);
  EXPECT_EQ(Contents(*bus.follower().map()), ContentsAfterSnapshotOf(map));
}

TEST(LossyNetworkTest, SendsLittleWhileNothingChangesAndStillSaysWhatIsSeen) {
  LossyBus bus(0.0, 3);
  ExampleMaps maps(3);
  TerrainMap map = maps.First(60);
  bus.Publish(map);
  bus.Run(milliseconds(2000));
  const std::size_t before = bus.num_terrain_bytes();
  for (int frame = 0; frame < 150; ++frame) {
    TerrainMap next = map;
    next.t_capture.ns += 66'667'000;
    for (auto& region : next.regions) {
      auto again = std::make_shared<TerrainRegion>(*region);
      again->last_seen = next.t_capture;
      region = again;
    }
    bus.Publish(next);
    bus.Run(milliseconds(67));
    map = next;
  }
  const double bytes_per_s = static_cast<double>(bus.num_terrain_bytes() - before) / 10.05;
  std::printf("60 regions seen, nothing changed: %.0f bytes a second\n", bytes_per_s);
  EXPECT_LE(bytes_per_s, 2000.0);
  const TerrainMapPtr& held = bus.follower().map();
  ASSERT_NE(held, nullptr);
  EXPECT_EQ(held->seq, map.seq);
  for (const auto& region : held->regions)
    EXPECT_LT(Seconds(map.t_capture - region->last_seen), 0.65) << "said twice a second";
}

TEST(LossyNetworkTest, SpreadsTheSnapshotOfALargeMapOverTimeNearRegionsFirst) {
  TerrainSender sender(std::nullopt, std::chrono::seconds(60), 0);
  ExampleMaps maps(4);
  auto map = std::make_shared<TerrainMap>(maps.First(1500));
  Time now{std::chrono::seconds(5)};
  MapChange change;
  change.map = map;
  std::vector<TerrainSender::Packet> packets = sender.Update(change, now);
  std::vector<double> distances;
  int num_ticks = 0;
  while (true) {
    std::size_t bytes = 0;
    for (const TerrainSender::Packet& packet : packets) {
      bytes += packet->size();
      const auto message = SafeDecode<terrain_v1_t>(packet->data(), packet->size());
      ASSERT_TRUE(message);
      for (const region_v1_t& region : message->regions) {
        const Eigen::Vector3d origin(region.origin[0], region.origin[1], region.origin[2]);
        if (region.piece == 0) distances.push_back((origin - map->T_world_left.translation()).norm());
      }
    }
    EXPECT_LE(bytes, 90'000u) << "at once";
    if (!sender.sending_snapshot()) break;
    now += milliseconds(20);
    packets = sender.Tick(now);
    ++num_ticks;
  }
  EXPECT_GT(num_ticks, 5);
  ASSERT_EQ(distances.size(), 1500u);
  const auto mean = [&](std::size_t first) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + 300; ++i) sum += distances[i];
    return sum / 300.0;
  };
  EXPECT_LT(mean(0), mean(1200));
}

}  // namespace
}  // namespace terrace
