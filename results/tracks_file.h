// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/landmark_sightings.h"
#include "core/time.h"

namespace terrace {

/// One line of tracks.jsonl.
struct ResultTracks {
  std::int64_t frame = 0;  ///< from 0, in the order of frames.jsonl
  Timestamp t_capture;
  FrameSightings sightings;
};

/// Without the end of the line. Pixels are rounded to tenths.
std::string TracksLine(const ResultTracks& tracks);
/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken.
std::vector<ResultTracks> ReadTracksFile(const std::filesystem::path& path);

}  // namespace terrace
