// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/channels.h"

#include <map>
#include <utility>

#include "core/field_problems.h"

namespace terrace {

PriorKind ChannelConfig::body_pose_prior() const {
  return body_pose_kind == "attitude" ? PriorKind::kAttitude : PriorKind::kLegOdometry;
}

std::vector<std::string> ChannelConfig::Problems() const {
  constexpr std::size_t kMaxChannelLength = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH
  const std::vector<std::pair<const char*, const std::string*>> channels = {{"images", &images},
                                                                            {"calibration", &calibration},
                                                                            {"imu", &imu},
                                                                            {"body_pose", &body_pose},
                                                                            {"body_prior", &body_prior},
                                                                            {"command", &command},
                                                                            {"reply", &reply},
                                                                            {"pose", &pose},
                                                                            {"pose_state", &pose_state},
                                                                            {"odometry", &odometry},
                                                                            {"terrain", &terrain},
                                                                            {"repair", &repair},
                                                                            {"request", &request},
                                                                            {"height_map", &height_map},
                                                                            {"octree", &octree},
                                                                            {"disparity", &disparity},
                                                                            {"map_box", &map_box},
                                                                            {"map_transform", &map_transform},
                                                                            {"loaded_map", &loaded_map},
                                                                            {"status", &status},
                                                                            {"footsteps", &footsteps},
                                                                            {"true_pose", &true_pose}};
  constexpr const char* kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-/:";
  FieldProblems problems;
  std::map<std::string, std::string> user;
  for (const auto& [field, channel] : channels) {
    problems.Require(!channel->empty() || channel == &body_pose, field, *channel, "name a channel");
    if (channel->empty()) continue;
    problems.Require(channel->size() <= kMaxChannelLength, field, *channel,
                     "be at most 63 characters long, as LCM has it");
    problems.Require(channel->find_first_not_of(kAllowed) == std::string::npos, field, *channel,
                     "hold letters, digits and _ - / : only");
    const auto [other, is_new] = user.emplace(*channel, field);
    problems.Require(is_new, field, *channel, "not be the channel of " + other->second + ", too");
  }
  problems.Require(body_pose_kind == "leg_odometry" || body_pose_kind == "attitude", "body_pose_kind",
                   body_pose_kind, "be leg_odometry or attitude");
  return problems.Take();
}

}  // namespace terrace
