// SPDX-License-Identifier: BSD-3-Clause
#include "bench/daemon/bus_watch.h"

#include <terrace/pose_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>

#include "lcmtypes/channels.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"

namespace terrace {

BusWatch::BusWatch(const std::string& url) : lcm_(url) {
  const ChannelConfig channels;
  Subscribe<&BusWatch::OnImages>(&lcm_, channels.images, this)->setQueueCapacity(100);
  Subscribe<&BusWatch::OnPose>(&lcm_, channels.pose_state, this)->setQueueCapacity(10000);
  Subscribe<&BusWatch::OnTerrain>(&lcm_, channels.terrain, this)->setQueueCapacity(100000);
  thread_ = std::thread([this] {
    while (!end_) lcm_.handleTimeout(20);
  });
}

BusWatch::~BusWatch() {
  end_ = true;
  thread_.join();
}

void BusWatch::OnImages(const lcm::ReceiveBuffer* buffer, const std::string&) {
  // utime follows the fingerprint; the images themselves need not be copied.
  constexpr std::uint32_t kBytes = 16;
  if (buffer->data_size < kBytes) return;
  const auto* data = static_cast<const std::uint8_t*>(buffer->data);
  std::uint64_t utime = 0;
  for (std::uint32_t i = 8; i < kBytes; ++i) utime = utime << 8 | data[i];
  const std::lock_guard lock(mutex_);
  frames_[static_cast<std::int64_t>(utime)].images = buffer->recv_utime;
}

void BusWatch::OnPose(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto pose = SafeDecode<pose_v1_t>(buffer->data, buffer->data_size);
  if (!pose) return;
  const std::lock_guard lock(mutex_);
  frames_[pose->utime].pose = buffer->recv_utime;
}

void BusWatch::OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  const auto terrain = SafeDecode<terrain_v1_t>(buffer->data, buffer->data_size);
  if (!terrain) return;
  constexpr std::size_t kHeaderBytes = 8 + 1;  // LCM's: magic, number, the channel's zero
  const std::lock_guard lock(mutex_);
  terrain_bytes_.emplace_back(buffer->recv_utime, buffer->data_size + channel.size() + kHeaderBytes);
  for (const region_v1_t& region : terrain->regions) ids_.emplace(region.id, buffer->recv_utime);
  if (terrain->kind == terrain_v1_t::SEEN) return;
  const bool is_new = states_.empty() || terrain->map_id > states_.back().map_id ||
                      (terrain->map_id == states_.back().map_id && terrain->seq > states_.back().seq);
  if (is_new) states_.push_back({buffer->recv_utime, terrain->map_id, terrain->seq});
  const bool is_newest = terrain->map_id == states_.back().map_id && terrain->seq == states_.back().seq;
  // Parts that are sent again later, because somebody lacks them, are not the first to come.
  const auto frame = frames_.find(terrain->utime);
  if (terrain->kind == terrain_v1_t::DELTA && is_newest && frame != frames_.end())
    frame->second.terrain = buffer->recv_utime;
}

std::map<std::int64_t, BusWatch::Frame> BusWatch::frames() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}

std::vector<BusWatch::State> BusWatch::states() const {
  const std::lock_guard lock(mutex_);
  return states_;
}

BusWatch::State BusWatch::StateAt(std::int64_t t) const {
  const std::lock_guard lock(mutex_);
  for (auto state = states_.rbegin(); state != states_.rend(); ++state)
    if (state->t_published <= t) return *state;
  return {};
}

std::int64_t BusWatch::TerrainBytesSince(std::int64_t t) const {
  const std::lock_guard lock(mutex_);
  std::int64_t sum = 0;
  for (const auto& [when, bytes] : terrain_bytes_)
    if (when >= t) sum += bytes;
  return sum;
}

int BusWatch::NewIdsSince(std::int64_t t) const {
  const std::lock_guard lock(mutex_);
  int count = 0;
  for (const auto& [id, when] : ids_) count += when >= t;
  return count;
}

}  // namespace terrace
