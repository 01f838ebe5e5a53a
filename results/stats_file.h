// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/pose_estimate.h"

namespace terrace {

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
  std::int64_t passed_over = 0;      ///< frames with a pose that the map had no time for
  std::int64_t lessons_skipped = 0;  ///< what later stages told earlier ones too late
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

/// The text of the file; stages in the order in which a frame passes them.
std::string StatsJson(const ReplayStats& stats);
/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken.
ReplayStats ReadStatsFile(const std::filesystem::path& path);

}  // namespace terrace
