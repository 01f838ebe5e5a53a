// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_client.h"

#include <chrono>
#include <optional>
#include <stdexcept>

#include "lcmtypes/subscribe.h"

namespace terrace {

TerrainClient::TerrainClient(lcm::LCM* lcm, const ChannelConfig& channels)
    : lcm_(lcm), repair_channel_(channels.repair) {
  subscription_ = lcm_->good() ? Subscribe<&TerrainClient::OnTerrain>(lcm_, channels.terrain, this) : nullptr;
  if (subscription_ == nullptr) throw std::runtime_error("cannot listen on " + channels.terrain);
  // A map in packets of 1,400 bytes comes in many; LCM keeps 30 by itself.
  constexpr int kPackets = 4000;
  subscription_->setQueueCapacity(kPackets);
  asking_ = std::thread([this] { AskUntilTheEnd(); });
}

TerrainClient::~TerrainClient() {
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  end_changed_.notify_one();
  asking_.join();
  lcm_->unsubscribe(subscription_);
}

TerrainMapPtr TerrainClient::map() const {
  const std::lock_guard lock(mutex_);
  return follower_.map();
}

bool TerrainClient::in_step() const {
  const std::lock_guard lock(mutex_);
  return follower_.in_step();
}

std::int64_t TerrainClient::num_bad_messages() const {
  const std::lock_guard lock(mutex_);
  return follower_.num_bad_messages();
}

void TerrainClient::OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const std::lock_guard lock(mutex_);
  follower_.Receive(buffer->data, buffer->data_size);
}

void TerrainClient::AskUntilTheEnd() {
  constexpr std::chrono::milliseconds kPeriod(10);
  std::unique_lock lock(mutex_);
  while (!end_) {
    std::optional<terrain_repair_v1_t> repair = follower_.TakeRepair(std::chrono::steady_clock::now());
    if (repair) {
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      repair->utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
      lock.unlock();
      lcm_->publish(repair_channel_, &*repair);
      lock.lock();
    }
    end_changed_.wait_for(lock, kPeriod, [this] { return end_; });
  }
}

}  // namespace terrace
