// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/channels.h"

#include <map>
#include <utility>

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
  std::vector<std::string> problems;
  std::map<std::string, std::string> user;
  for (const auto& [field, channel] : channels) {
    const std::string name = field;
    if (channel->empty()) {
      if (channel != &body_pose) problems.push_back(name + " is empty");
      continue;
    }
    if (channel->size() > kMaxChannelLength) {
      problems.push_back(name + " = '" + *channel + "' is longer than LCM's 63 characters");
    }
    if (channel->find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-/:") !=
        std::string::npos) {
      problems.push_back(name + " = '" + *channel + "' may hold letters, digits and _ - / : only");
    }
    const auto [other, is_new] = user.emplace(*channel, name);
    if (!is_new) problems.push_back(name + " and " + other->second + " are both '" + *channel + "'");
  }
  if (body_pose_kind != "leg_odometry" && body_pose_kind != "attitude") {
    problems.push_back("body_pose_kind = '" + body_pose_kind + "' must be leg_odometry or attitude");
  }
  return problems;
}

}  // namespace terrace
