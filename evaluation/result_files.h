// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/geometry.h"
#include "core/landmark_sightings.h"
#include "core/pose_estimate.h"
#include "core/terrain_map.h"
#include "core/time.h"

namespace terrace {

/// One line of trajectory.tum.
struct ResultPose {
  Timestamp t_capture;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
};

/// One line of frames.jsonl.
struct ResultFrame {
  Timestamp t_capture;
  TrackingStatus status = TrackingStatus::kLost;
  std::string reason;
  std::optional<Matrix6d> covariance;  ///< rotation [rad], translation [m]; left frame; none when lost
  std::optional<double> latency_ms;    ///< only of a replay at recorded speed
  std::int64_t map_cells = 0;
  std::int64_t regions = 0;
  int epoch = 0;  ///< jumps of the world so far
};

/// One line of staircases.jsonl.
struct StaircaseReport {
  Timestamp t_capture;
  Staircase staircase;
};

/// One line of tracks.jsonl.
struct ResultTracks {
  std::int64_t frame = 0;  ///< from 0, in the order of frames.jsonl
  Timestamp t_capture;
  FrameSightings sightings;
};

/// camera.json.
struct ResultCamera {
  StereoCamera camera;
  Eigen::Matrix3d R_rect_raw = Eigen::Matrix3d::Identity();  ///< p_rectified = R_rect_raw * p_raw
  std::optional<Eigen::Isometry3d> T_body_left;
};

struct StageTimes {
  std::int64_t count = 0;
  double cpu_ms_mean = 0.0;
  double p50_ms = 0.0;
  double p90_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
};

struct LatencyMs {
  double p50 = 0.0;
  double p90 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// stats.json.
struct ReplayStats {
  std::int64_t frames = 0;
  std::int64_t tracked = 0;
  std::int64_t dropped = 0;
  double rate_hz = 0.0;
  double peak_rss_mib = 0.0;
  std::int64_t map_bytes = 0;
  std::int64_t map_cells = 0;
  std::string map_sha256;
  Gravity gravity;
  std::optional<LatencyMs> latency;
  std::map<std::string, StageTimes> stages;

  /// The stages in the order in which a frame passes them, those of unknown name at the end.
  std::vector<std::pair<std::string, StageTimes>> StagesInOrder() const;
};

/// Everything that `terraced replay` leaves in a folder, but images and tracks, which are read one by one.
struct ReplayResult {
  std::filesystem::path folder;
  std::vector<ResultPose> trajectory;  ///< ascending in time
  TerrainMap map;
  std::vector<ResultFrame> frames;
  std::vector<StaircaseReport> staircase_reports;
  ResultCamera camera;
  ReplayStats stats;
};

// Each throws FileError (datasets/file_bytes.h) with the file, the place and the rule that is broken.
ReplayResult ReadReplayResult(const std::filesystem::path& folder);
std::vector<ResultPose> ReadTrajectoryFile(const std::filesystem::path& path);
TerrainMap ReadTerrainMapFile(const std::filesystem::path& path);
std::vector<ResultFrame> ReadFramesFile(const std::filesystem::path& path);
std::vector<StaircaseReport> ReadStaircasesFile(const std::filesystem::path& path);
ResultCamera ReadCameraFile(const std::filesystem::path& path);
ReplayStats ReadStatsFile(const std::filesystem::path& path);
std::vector<ResultTracks> ReadTracksFile(const std::filesystem::path& path);

// Images that a replay saved, by capture time; empty when it saved none.
std::map<Timestamp, std::filesystem::path> SavedDisparities(const std::filesystem::path& result_folder);
/// The rectified left images that belong to tracks.jsonl.
std::map<Timestamp, std::filesystem::path> SavedTrackImages(const std::filesystem::path& result_folder);

}  // namespace terrace
