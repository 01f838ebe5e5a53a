// SPDX-License-Identifier: BSD-3-Clause
#include "results/replay_result.h"

#include <charconv>
#include <string>
#include <system_error>

namespace terrace {
namespace {

constexpr const char* kFiles[] = {"trajectory.tum", "terrain_map.json", "frames.jsonl", "staircases.jsonl",
                                  "camera.json",    "stats.json",       "tracks.jsonl", "explanations.jsonl"};
constexpr const char* kImageFolders[] = {"disparity", "tracks"};

/// `<t_capture_ns>.png` of a folder, by time.
std::map<Timestamp, std::filesystem::path> ImagesIn(const std::filesystem::path& folder) {
  std::map<Timestamp, std::filesystem::path> images;
  if (!std::filesystem::is_directory(folder)) return images;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    // Other images of the folder (confidence, colour) have an underscore in the name.
    if (entry.path().extension() != ".png") continue;
    const std::string stem = entry.path().stem().string();
    Timestamp t;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), t.ns);
    if (error == std::errc() && end == stem.data() + stem.size()) images[t] = entry.path();
  }
  return images;
}

}  // namespace

ReplayResult ReadReplayResult(const std::filesystem::path& folder) {
  ReplayResult result;
  result.folder = folder;
  result.trajectory = ReadTrajectoryFile(folder / "trajectory.tum");
  result.map = ReadTerrainMapFile(folder / "terrain_map.json");
  result.frames = ReadFramesFile(folder / "frames.jsonl");
  result.staircase_reports = ReadStaircasesFile(folder / "staircases.jsonl");
  result.camera = ReadCameraFile(folder / "camera.json");
  result.stats = ReadStatsFile(folder / "stats.json");
  result.map.gravity = result.stats.gravity;
  return result;
}

std::map<Timestamp, std::filesystem::path> SavedDisparities(const std::filesystem::path& result_folder) {
  return ImagesIn(result_folder / "disparity");
}

std::map<Timestamp, std::filesystem::path> SavedTrackImages(const std::filesystem::path& result_folder) {
  return ImagesIn(result_folder / "tracks");
}

void RemoveResults(const std::filesystem::path& folder) {
  std::error_code error;  // what cannot be removed is noticed when it is written anew
  for (const char* file : kFiles) std::filesystem::remove(folder / file, error);
  for (const char* images : kImageFolders) std::filesystem::remove_all(folder / images, error);
}

}  // namespace terrace
