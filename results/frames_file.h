// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "core/time.h"

namespace terrace {

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

/// Without the end of the line.
std::string FrameLine(const ResultFrame& frame);
/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken.
std::vector<ResultFrame> ReadFramesFile(const std::filesystem::path& path);

}  // namespace terrace
