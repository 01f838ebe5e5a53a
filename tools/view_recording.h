// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "results/replay_result.h"
#include "tools/view_record.h"

namespace terrace {

/// A map alone: one moment. Throws FileError (core/file_bytes.h).
std::vector<ViewBytes> RecordsOfMap(const std::filesystem::path& file);

/// A picture of a finished run, shown beside its figures.
struct ViewPicture {
  std::string caption;
  Timestamp t_capture;
  std::string jpeg;
};

/// What is shown beside a result.
struct ViewBeside {
  std::vector<std::pair<std::string, std::string>> rows;  ///< figures, after those of the replay
  std::vector<ViewPicture> pictures;
};

/// A replay's result: the way frame by frame, the regions as they stood at the end, each from when it was
/// first seen, and the figures. @param source  "result" or "report"
std::vector<ViewBytes> RecordsOfResult(const ReplayResult& result, const std::string& source,
                                       const ViewBeside& beside = {});

/// What a daemon published, from an LCM log. Throws FileError when the log has no map of a daemon.
std::vector<ViewBytes> RecordsOfLog(const std::filesystem::path& file);

}  // namespace terrace
