// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/terrain_publisher.h"

#include <chrono>
#include <utility>

#include "lcmtypes/codec.h"

namespace terrace {
namespace {

Eigen::Isometry3d LevelBody() {
  Eigen::Isometry3d T_body_left = Eigen::Isometry3d::Identity();
  T_body_left.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T_body_left;
}

std::int64_t MicrosecondsNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

}  // namespace

TerrainPublisher::TerrainPublisher(lcm::LCM* lcm, ChannelConfig channels,
                                   std::optional<Eigen::Isometry3d> T_body_left, double snapshot_period_s)
    : lcm_(lcm),
      channels_(std::move(channels)),
      T_body_left_(T_body_left.value_or(LevelBody())),
      snapshot_period_(static_cast<std::int64_t>(snapshot_period_s * 1e9)),
      first_map_id_(MicrosecondsNow()) {}

void TerrainPublisher::PublishPose(const PoseEstimate& pose) {
  const std::lock_guard lock(pose_mutex_);
  Send(channels_.odometry, ToUpdateMessage(pose, t_pose_));
  if (pose.status != TrackingStatus::kLost) Send(channels_.pose, ToPoseMessage(pose, T_body_left_, t_pose_));
  t_pose_ = pose.t_capture;
}

void TerrainPublisher::PublishTerrain(const TerrainMapPtr& map) {
  const std::lock_guard lock(mutex_);
  const bool new_map = !sent_ || sent_->map_id != map->map_id;
  const bool snapshot_due = new_map || map->t_capture - t_snapshot_ >= snapshot_period_;
  const bool changed = new_map || sent_->seq != map->seq;
  if (!new_map && changed) SendTerrain(DeltaMessages(*sent_, *map));
  sent_ = map;
  if (snapshot_due) {
    SendTerrain(SnapshotMessages(*map));
    t_snapshot_ = map->t_capture;
  }
}

bool TerrainPublisher::SendSnapshot() {
  const std::lock_guard lock(mutex_);
  if (!sent_) return false;
  SendTerrain(SnapshotMessages(*sent_));
  t_snapshot_ = sent_->t_capture;
  return true;
}

void TerrainPublisher::Publish(const Status& status) {
  const std::lock_guard lock(mutex_);
  Send(channels_.status, ToMessage(status));
}

std::int64_t TerrainPublisher::num_failures() const { return num_failures_; }

template <typename Message>
void TerrainPublisher::Send(const std::string& channel, const Message& message) {
  if (lcm_->publish(channel, &message) != 0) ++num_failures_;
}

template <typename Messages>
void TerrainPublisher::SendTerrain(Messages messages) {
  for (auto& message : messages) {
    message.map_id += first_map_id_;
    Send(channels_.terrain, message);
  }
}

}  // namespace terrace
