// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "daemon/config.h"

namespace terrace {

struct LiveOptions {
  /// Folder for the result files, written at the end; empty: none.
  std::filesystem::path output;
  bool overwrite = false;
  /// Threads that the whole daemon may use.
  int num_threads = 2;
};

/// Maps what comes over LCM and publishes the map, until an interrupt ends it; the results are written then.
/// Throws OutputError, SequenceError (calibration folder), ConfigError (mask), or what a stage throws.
void RunLive(const LiveOptions& options, const Config& config);

}  // namespace terrace
