// SPDX-License-Identifier: BSD-3-Clause
#include "tools/cheetah_peer.h"

namespace terrace {

void CheetahPeer::Tick(Time now) {
  const std::optional<BodyPose> pose = client_->newest_pose();
  const TerrainMapPtr map = client_->map();
  problem_ = ProblemOf(pose);
  if (problem_.empty() && map) {
    // Heights of another world have another zero.
    if (pose->epoch != epoch_) ground_z_world_.reset();
    epoch_ = pose->epoch;
    if (!ground_z_world_) ground_z_world_ = GroundUnder(QueryTo(map), pose->T_world_body->translation());
    if (!ground_z_world_) problem_ = "no ground is known under the robot yet";
  }
  if (problem_.empty() && t_pose_ != pose->t_capture) {
    t_pose_ = pose->t_capture;
    body_world_ = pose->T_world_body->translation();
    const localization_lcmt message = CheetahLocalization(*pose->T_world_body, *ground_z_world_);
    walker_->publish("global_to_robot", &message);
  }
  if (t_ground_ && now - *t_ground_ < period_) return;
  t_ground_ = now;
  // A walker that hears nothing goes on with what it heard last.
  SendGround(problem_.empty() ? CheetahMapsOf(QueryTo(map), *pose->T_world_body, *ground_z_world_, foot_)
                              : CheetahMapsOfNothing(body_world_, ground_z_world_.value_or(0.0)));
}

std::string CheetahPeer::ProblemOf(const std::optional<BodyPose>& pose) const {
  constexpr double kSilent_s = 1.5;
  const ClientHealth health = client_->Health();
  if (!health.silence_s) return "nothing has been heard of the daemon yet";
  if (*health.silence_s > kSilent_s) return "the daemon is silent";
  if (!client_->map()) return "no map has come yet";
  if (!pose) return "no pose has come yet";
  if (pose->status == TrackingStatus::kLost || !pose->T_world_body)
    return "the robot is lost: " + pose->reason;
  if (pose->map_id != 0 && client_->map()->map_id != pose->map_id)
    return "the map of this world has not come yet";
  return "";
}

void CheetahPeer::SendGround(const CheetahMaps& maps) {
  walker_->publish("local_heightmap", &maps.heights);
  walker_->publish("traversability", &maps.traversability);
}

const TerrainQuery& CheetahPeer::QueryTo(const TerrainMapPtr& map) {
  if (!query_ || &query_->map() != map.get()) query_ = std::make_unique<TerrainQuery>(map, query_.get());
  return *query_;
}

}  // namespace terrace
