// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/config.h"

namespace terrace {

struct ReplayOptions {
  std::filesystem::path sequence;
  std::filesystem::path output;
  /// Calibration files to use instead of what the sequence says; empty: none.
  std::vector<std::filesystem::path> calibration;
  /// Hand frames over at their recorded times; the newest wins, as live.
  bool realtime = false;
  /// LCM provider to publish on; empty: none.
  std::string publish_url;
  /// A .terrace file to write at the end, with the views by which its places are recognised; empty: none.
  std::filesystem::path save_map;
  bool overwrite = false;
  int save_disparity_every = 0;
  /// Pictures of tracked landmarks, spread over the run.
  int num_track_pictures = 0;
  /// Threads that the whole daemon may use.
  int num_threads = 2;
};

/// Plays a recorded sequence through the whole mapper, writes the result files and prints a summary. An
/// interrupt or a truncated sequence ends it early with the results of what was read. Throws SequenceError,
/// OutputError, or what a stage throws.
void RunReplay(const ReplayOptions& options, const Config& config);

}  // namespace terrace
