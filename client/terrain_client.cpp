// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_client.h"

#include <stdexcept>

#include <terrace/command_v1_t.hpp>

#include "lcmtypes/subscribe.h"

namespace terrace {

TerrainClient::TerrainClient(lcm::LCM* lcm, const ChannelConfig& channels)
    : lcm_(lcm), command_channel_(channels.command) {
  subscription_ = lcm_->good() ? Subscribe<&TerrainClient::OnTerrain>(lcm_, channels.terrain, this) : nullptr;
  if (subscription_ == nullptr) throw std::runtime_error("cannot listen on " + channels.terrain);
  AskForSnapshot();
}

TerrainClient::~TerrainClient() { lcm_->unsubscribe(subscription_); }

void TerrainClient::OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string&) {
  follower_.Receive(buffer->data, buffer->data_size);
  if (follower_.needs_snapshot()) AskForSnapshot();
}

void TerrainClient::AskForSnapshot() {
  constexpr std::chrono::seconds kPatience(1);
  const auto now = std::chrono::steady_clock::now();
  if (asked_ && now - *asked_ < kPatience) return;
  asked_ = now;
  command_v1_t command{};
  command.utime = std::chrono::duration_cast<std::chrono::microseconds>(
                      std::chrono::system_clock::now().time_since_epoch())
                      .count();
  command.request_id = ++num_requests_;
  command.command = command_v1_t::SEND_SNAPSHOT;
  lcm_->publish(command_channel_, &command);
}

}  // namespace terrace
