// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/sensor_frame.h"

namespace terrace {

/// On which LCM channel each message travels. YAML section: `channels`.
struct ChannelConfig {
  /// Stereo pairs, `images_t`; in.
  std::string images = "TERRACE_IMAGES";
  /// The stereo rig, `calibration_v1_t`; in.
  std::string calibration = "TERRACE_CALIBRATION";
  /// IMU readings, `imu_v1_t`; in.
  std::string imu = "TERRACE_IMU";
  /// What the robot believes about its body, `body_prior_v1_t`; in.
  std::string body_prior = "TERRACE_BODY_PRIOR";
  /// The same from a robot that publishes `pose_t`; in. Empty: none.
  std::string body_pose = "";
  /// What a pose on `body_pose` is taken as: `leg_odometry` or `attitude`.
  std::string body_pose_kind = "leg_odometry";
  /// Commands to the daemon, `command_v1_t`; in.
  std::string command = "TERRACE_COMMAND";
  /// Answers to commands, `command_reply_v1_t`; out.
  std::string reply = "TERRACE_REPLY";
  /// The body in the world, `pose_t`; out.
  std::string pose = "TERRACE_POSE";
  /// The body in the world with covariance, status and reason, `pose_v1_t`; out.
  std::string pose_state = "TERRACE_POSE_STATE";
  /// Motion of the left camera between frames, `update_t`; out.
  std::string odometry = "TERRACE_ODOMETRY";
  /// The labelled map, `terrain_v1_t`; out.
  std::string terrain = "TERRACE_TERRAIN";
  /// What subscribers lack of the terrain, `terrain_repair_v1_t`; in.
  std::string repair = "TERRACE_REPAIR";
  /// Requests for what is not sent by itself, `terrain_request_v1_t`; in.
  std::string request = "TERRACE_REQUEST";
  /// Heights on a grid, `height_map_v1_t`, on request; out.
  std::string height_map = "TERRACE_HEIGHT_MAP";
  /// Leaves of the octree, `octree_v1_t`, on request; out.
  std::string octree = "TERRACE_OCTREE";
  /// The newest disparity image, `disparity_v1_t`, on request; out.
  std::string disparity = "TERRACE_DISPARITY";
  /// The regions in a box, `terrain_v1_t`, on request; out.
  std::string map_box = "TERRACE_MAP_BOX";
  /// Where a loaded map lies in the world, `map_transform_v1_t`; out.
  std::string map_transform = "TERRACE_MAP_TRANSFORM";
  /// A loaded map in its own frame, while it is not known where it lies, `terrain_v1_t`; out.
  std::string loaded_map = "TERRACE_LOADED_MAP";
  /// The daemon's state, `status_v1_t`; out.
  std::string status = "TERRACE_STATUS";
  /// Where a planner sets its feet, `footstep_plan_v1_t`; never read by the mapper.
  std::string footsteps = "TERRACE_FOOTSTEPS";
  /// True poses of the body in converted logs, `pose_t`; never read by the mapper.
  std::string true_pose = "TERRACE_TRUE_POSE";

  /// body_pose_kind as a prior's kind.
  PriorKind body_pose_prior() const;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
