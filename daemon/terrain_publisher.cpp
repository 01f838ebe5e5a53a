// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/terrain_publisher.h"

#include <utility>

#include "lcmtypes/pose_codec.h"

namespace terrace {
namespace {

/// Map ids count from the start of the daemon; this makes them differ from those of an earlier one.
std::int64_t MicrosecondsNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

TerrainSender::Time Now() { return std::chrono::steady_clock::now(); }

}  // namespace

Eigen::Isometry3d LevelBody() {
  Eigen::Isometry3d T_body_left = Eigen::Isometry3d::Identity();
  T_body_left.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T_body_left;
}

TerrainPublisher::TerrainPublisher(lcm::LCM* lcm, ChannelConfig channels,
                                   std::optional<Eigen::Isometry3d> T_body_left, double snapshot_period_s)
    : lcm_(lcm),
      channels_(std::move(channels)),
      T_body_left_(T_body_left.value_or(LevelBody())),
      sender_(T_body_left_, std::chrono::nanoseconds(static_cast<std::int64_t>(snapshot_period_s * 1e9)),
              MicrosecondsNow()) {}

void TerrainPublisher::PublishPose(const PoseEstimate& pose) {
  const std::lock_guard lock(pose_mutex_);
  const update_t motion = ToUpdateMessage(pose, t_pose_);
  lcm_->publish(channels_.odometry, &motion);
  const pose_v1_t state = ToMessage(BodyPoseOf(pose, T_body_left_, t_pose_, map_id_));
  lcm_->publish(channels_.pose_state, &state);
  if (pose.status != TrackingStatus::kLost) {
    const pose_t body = ToPoseMessage(pose, T_body_left_, t_pose_);
    lcm_->publish(channels_.pose, &body);
  }
  t_pose_ = pose.t_capture;
}

void TerrainPublisher::PublishTerrain(const MapChange& change) {
  const std::lock_guard lock(mutex_);
  Send(sender_.Update(change, Now()));
  map_id_ = sender_.map_id();
}

void TerrainPublisher::Answer(const terrain_repair_v1_t& repair) {
  const std::lock_guard lock(mutex_);
  Send(sender_.Answer(repair, Now()));
}

void TerrainPublisher::Tick() {
  const std::lock_guard lock(mutex_);
  Send(sender_.Tick(Now()));
}

bool TerrainPublisher::SendSnapshot() {
  const std::lock_guard lock(mutex_);
  if (!sender_.RequestSnapshot()) return false;
  Send(sender_.Tick(Now()));
  return true;
}

bool TerrainPublisher::sending_snapshot() const {
  const std::lock_guard lock(mutex_);
  return sender_.sending_snapshot();
}

void TerrainPublisher::Describe(Status* status) const {
  const std::lock_guard lock(mutex_);
  status->map_id = sender_.map_id();
  status->map_seq = sender_.seq();
}

void TerrainPublisher::Send(const std::vector<TerrainSender::Packet>& packets) {
  for (const TerrainSender::Packet& packet : packets)
    lcm_->publish(channels_.terrain, packet->data(), static_cast<unsigned int>(packet->size()));
}

}  // namespace terrace
