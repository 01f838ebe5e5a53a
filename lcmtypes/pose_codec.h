// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>
#include <terrace/pose_t.hpp>
#include <terrace/pose_v1_t.hpp>
#include <terrace/update_t.hpp>

#include "core/body_pose.h"
#include "core/pose_estimate.h"
#include "core/time.h"

namespace terrace {

/// Velocities are the mean since `t_prev`, the frame before; none without one, and none when lost.
BodyPose BodyPoseOf(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                    std::optional<Timestamp> t_prev, std::int64_t map_id);

pose_v1_t ToMessage(const BodyPose& pose);
std::optional<BodyPose> FromMessage(const pose_v1_t& message);

/// Body in world. Velocities are the mean since `t_prev`, the frame before; zero when there is none.
pose_t ToPoseMessage(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                     std::optional<Timestamp> t_prev);

/// Motion of the left camera since `t_prev`, the frame before. Without one, or when lost: NO_DATA; when
/// bridging: ESTIMATE_INSUFFICIENT_FEATURES.
update_t ToUpdateMessage(const PoseEstimate& pose, std::optional<Timestamp> t_prev);

/// A pose by itself, velocities zero.
pose_t ToMessage(Timestamp t, const Eigen::Isometry3d& T_world_body);
std::optional<Eigen::Isometry3d> FromMessage(const pose_t& message);

}  // namespace terrace
