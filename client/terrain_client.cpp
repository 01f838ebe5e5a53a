// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_client.h"

#include <chrono>
#include <optional>
#include <stdexcept>
#include <utility>

#include "client/map_from_log.h"
#include "client/terrace_file.h"
#include "lcmtypes/map_transform_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/subscribe.h"

namespace terrace {

TerrainClient::TerrainClient(lcm::LCM* lcm, const ChannelConfig& channels)
    : lcm_(lcm), repair_channel_(channels.repair) {
  Subscribe(channels);
  asking_ = std::thread([this] { AskUntilTheEnd(); });
}

void TerrainClient::Subscribe(const ChannelConfig& channels) {
  // A map in packets of 1,400 bytes comes in many; LCM keeps 30 by itself.
  constexpr int kPackets = 4000;
  const auto keep = [&](lcm::Subscription* subscription, const std::string& channel, int capacity) {
    if (subscription == nullptr) throw std::runtime_error("cannot listen on " + channel);
    subscription->setQueueCapacity(capacity);
    subscriptions_.push_back(subscription);
  };
  if (!lcm_->good()) throw std::runtime_error("cannot listen on " + channels.terrain);
  keep(terrace::Subscribe<&TerrainClient::OnTerrain>(lcm_, channels.terrain, this), channels.terrain,
       kPackets);
  keep(terrace::Subscribe<&TerrainClient::OnPose>(lcm_, channels.pose_state, this), channels.pose_state, 30);
  keep(terrace::Subscribe<&TerrainClient::OnMapTransform>(lcm_, channels.map_transform, this),
       channels.map_transform, 30);
  keep(terrace::Subscribe<&TerrainClient::OnStatus>(lcm_, channels.status, this), channels.status, 30);
}

TerrainClient::~TerrainClient() {
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  end_changed_.notify_one();
  asking_.join();
  for (lcm::Subscription* subscription : subscriptions_) lcm_->unsubscribe(subscription);
}

TerrainMapPtr TerrainClient::LoadMap(const std::filesystem::path& file) { return LoadTerraceFile(file).map; }

TerrainMapPtr TerrainClient::FromLog(const std::filesystem::path& log, Timestamp t,
                                     const ChannelConfig& channels) {
  return MapFromLog(log, t, channels);
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

void TerrainClient::OnChange(ChangeHandler handler) { on_change_ = std::move(handler); }

std::optional<BodyPose> TerrainClient::BodyPoseAt(Timestamp t) const {
  const std::lock_guard lock(mutex_);
  return poses_.At(t);
}

std::optional<BodyPose> TerrainClient::newest_pose() const {
  const std::lock_guard lock(mutex_);
  return poses_.newest();
}

std::optional<MapTransform> TerrainClient::map_transform() const {
  const std::lock_guard lock(mutex_);
  return map_transform_;
}

ClientHealth TerrainClient::Health() const {
  const std::lock_guard lock(mutex_);
  ClientHealth health;
  if (t_heard_) health.silence_s = Seconds(std::chrono::steady_clock::now() - *t_heard_);
  const std::optional<BodyPose> pose = poses_.newest();
  std::optional<Timestamp> t_image;
  if (pose) t_image = pose->t_capture;
  if (follower_.map() && (!t_image || *t_image < follower_.map()->t_capture))
    t_image = follower_.map()->t_capture;
  if (t_image) {
    const std::chrono::nanoseconds now = std::chrono::system_clock::now().time_since_epoch();
    health.image_age_s = Seconds(Timestamp{now.count()} - *t_image);
  }
  if (status_) health.state = status_->state;
  if (pose) health.tracking = pose->status;
  health.reason = pose && !pose->reason.empty() ? pose->reason : status_ ? status_->reason : "";
  health.in_step = follower_.in_step();
  health.num_repairs = num_repairs_;
  health.num_bad_terrain = follower_.num_bad_messages();
  health.num_bad_pose = num_bad_pose_;
  health.num_bad_status = num_bad_status_;
  return health;
}

void TerrainClient::OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string&) {
  TerrainMapPtr before, map;
  {
    const std::lock_guard lock(mutex_);
    before = follower_.map();
    const std::int64_t num_bad = follower_.num_bad_messages();
    follower_.Receive(buffer->data, buffer->data_size);
    if (follower_.num_bad_messages() == num_bad) t_heard_ = std::chrono::steady_clock::now();
    map = follower_.map();
  }
  if (on_change_ && map != before) TellChange(before, map);
}

void TerrainClient::TellChange(const TerrainMapPtr& before, const TerrainMapPtr& map) const {
  const TerrainMap nothing;
  const bool another = before && before->map_id != map->map_id;
  if (another) on_change_(DifferenceBetween(*before, nothing), nullptr);
  on_change_(DifferenceBetween(another || !before ? nothing : *before, *map), map);
}

void TerrainClient::OnPose(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<pose_v1_t>(buffer->data, buffer->data_size);
  const std::optional<BodyPose> pose = message ? FromMessage(*message) : std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!pose) {
    ++num_bad_pose_;
    return;
  }
  t_heard_ = std::chrono::steady_clock::now();
  poses_.Add(*pose);
}

void TerrainClient::OnMapTransform(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<map_transform_v1_t>(buffer->data, buffer->data_size);
  const std::optional<MapTransform> transform = message ? FromMessage(*message) : std::nullopt;
  if (!transform) return;
  const std::lock_guard lock(mutex_);
  map_transform_ = transform;
}

void TerrainClient::OnStatus(const lcm::ReceiveBuffer* buffer, const std::string&) {
  const auto message = SafeDecode<status_v1_t>(buffer->data, buffer->data_size);
  std::optional<Status> status = message ? FromMessage(*message) : std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!status) {
    ++num_bad_status_;
    return;
  }
  t_heard_ = std::chrono::steady_clock::now();
  status_ = std::move(status);
}

void TerrainClient::AskUntilTheEnd() {
  constexpr std::chrono::milliseconds kPeriod(10);
  std::unique_lock lock(mutex_);
  while (!end_) {
    std::optional<terrain_repair_v1_t> repair = follower_.TakeRepair(std::chrono::steady_clock::now());
    if (repair) {
      ++num_repairs_;
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
