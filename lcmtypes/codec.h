// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <terrace/body_prior_v1_t.hpp>
#include <terrace/calibration_v1_t.hpp>
#include <terrace/imu_v1_t.hpp>
#include <terrace/pose_t.hpp>
#include <terrace/region_v1_t.hpp>
#include <terrace/staircase_v1_t.hpp>
#include <terrace/status_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>
#include <terrace/update_t.hpp>

#include "core/camera.h"
#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "core/status.h"
#include "core/terrain_map.h"

namespace terrace {

// Conversions between the messages and the plain structs of core. ToMessage never fails. FromMessage gives
// nothing when a value cannot be meant: not a number, a label that does not exist, rings that do not add up.

/// The moment, when it lies between 1970 and 2116: what is outside is no time, and would overflow
/// differences.
std::optional<Timestamp> TimeFromNanoseconds(std::int64_t ns);
std::optional<Timestamp> TimeFromMicroseconds(std::int64_t utime);

/// Body in world. Velocities are the mean since `t_prev`, the frame before; zero when there is none.
pose_t ToPoseMessage(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                     std::optional<Timestamp> t_prev);

/// Motion of the left camera since `t_prev`, the frame before. Without one, or when lost: NO_DATA; when
/// bridging: ESTIMATE_INSUFFICIENT_FEATURES.
update_t ToUpdateMessage(const PoseEstimate& pose, std::optional<Timestamp> t_prev);

/// A pose by itself, velocities zero.
pose_t ToMessage(Timestamp t, const Eigen::Isometry3d& T_world_body);
std::optional<Eigen::Isometry3d> FromMessage(const pose_t& message);

imu_v1_t ToMessage(const ImuSample& sample);
std::optional<ImuSample> FromMessage(const imu_v1_t& message);

/// The rotation travels as CanonicalQuaternion.
body_prior_v1_t ToMessage(const BodyPrior& prior);
std::optional<BodyPrior> FromMessage(const body_prior_v1_t& message);
/// A prior from a robot that publishes poses without covariance.
std::optional<BodyPrior> PriorFromPose(const pose_t& message, PriorKind kind);

/// T_body_rawleft and T_body_imu travel as CanonicalQuaternion, everything else as it is. Both cameras must
/// have the same distortion model (a broken promise otherwise).
calibration_v1_t ToMessage(const StereoCalibration& calibration, Timestamp t);
/// Structure only: ask the result for its Problems().
std::optional<StereoCalibration> FromMessage(const calibration_v1_t& message);

status_v1_t ToMessage(const Status& status);
std::optional<Status> FromMessage(const status_v1_t& message);

/// The plane frame has its origin at the mean of the outline's vertices and the axes of AxesOf(normal).
region_v1_t ToMessage(const TerrainRegion& region, const Gravity& gravity);
std::optional<TerrainRegion> FromMessage(const region_v1_t& message);

staircase_v1_t ToMessage(const Staircase& staircase);
std::optional<Staircase> FromMessage(const staircase_v1_t& message);

/// What every part of a terrain_v1_t says beside regions and staircases.
struct TerrainView {
  Timestamp t_capture;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  Eigen::Vector3d down_world = -Eigen::Vector3d::UnitZ();
};
std::optional<TerrainView> FromMessage(const terrain_v1_t& message);

/// What LCM sends in one UDP packet; a message in several packets is lost with any of them.
inline constexpr std::size_t kMaxTerrainMessageBytes = 60000;

/// The whole map, in parts of at most `max_bytes` each (a single region or the staircases may be larger).
std::vector<terrain_v1_t> SnapshotMessages(const TerrainMap& map,
                                           std::size_t max_bytes = kMaxTerrainMessageBytes);
/// What must change to turn `base` into `map`, which must be of the same map_id. Regions are compared by
/// address: an unchanged region is shared between maps.
std::vector<terrain_v1_t> DeltaMessages(const TerrainMap& base, const TerrainMap& map,
                                        std::size_t max_bytes = kMaxTerrainMessageBytes);

}  // namespace terrace
