// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/replay_result.h"
#include "tools/view_record.h"
#include "tools/view_recording.h"

namespace terrace {

/// Where a report takes its images from.
struct ReportSource {
  std::string sequence;                            ///< what was replayed
  std::vector<std::filesystem::path> calibration;  ///< that the replay was given, if it was
  int num_images = 12;
};

/// A replay's map, path, figures and images as one page that needs no server.
/// @param page  from ReadViewPage
/// @param beside  its pictures are made here
/// @param more  records that come with those of the result
/// Throws std::runtime_error when the sequence is not the one of the result, and FileError.
std::string ReportPage(const std::string& page, const ReplayResult& result, const ReportSource& source,
                       ViewBeside beside = {}, const std::vector<ViewBytes>& more = {});

}  // namespace terrace
