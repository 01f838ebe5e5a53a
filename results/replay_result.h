// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "core/terrain_map.h"
#include "core/time.h"
#include "results/camera_file.h"
#include "results/frames_file.h"
#include "results/map_file.h"
#include "results/stats_file.h"
#include "results/tracks_file.h"
#include "results/trajectory_file.h"

namespace terrace {

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

/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken.
ReplayResult ReadReplayResult(const std::filesystem::path& folder);

// Images that a replay saved, by capture time; empty when it saved none.
std::map<Timestamp, std::filesystem::path> SavedDisparities(const std::filesystem::path& result_folder);
/// The rectified left images that belong to tracks.jsonl.
std::map<Timestamp, std::filesystem::path> SavedTrackImages(const std::filesystem::path& result_folder);

/// Removes the files of an earlier run, and nothing else.
void RemoveResults(const std::filesystem::path& folder);

}  // namespace terrace
