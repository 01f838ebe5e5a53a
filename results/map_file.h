// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/terrain_map.h"
#include "core/time.h"

namespace terrace {

/// The map as the text of terrain_map.json: a function of the map alone.
std::string TerrainMapJson(const TerrainMap& map);
/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken. Of a staircase
/// the edges follow from a straight flight.
TerrainMap ReadTerrainMapFile(const std::filesystem::path& path);

/// One line of staircases.jsonl.
struct StaircaseReport {
  Timestamp t_capture;
  Staircase staircase;
};
/// Without the end of the line.
std::string StaircaseLine(const StaircaseReport& report);
/// Throws FileError.
std::vector<StaircaseReport> ReadStaircasesFile(const std::filesystem::path& path);

}  // namespace terrace
