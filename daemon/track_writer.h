// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>

#include "daemon/pipeline.h"

namespace terrace {

/// Writes the landmarks that were tracked in some frames, spread over a run, and in those straight before
/// each: tracks.jsonl, a line a frame, and tracks/, the rectified left image of each of the former. The size
/// is bounded by the number of these, however long the run.
class TrackWriter {
 public:
  /// @param num_frames  of the whole run
  TrackWriter(const std::filesystem::path& dir, int num_pictures, std::int64_t num_frames);

  void AddFrame(const FrameResult& result);
  /// Throws OutputError when something could not be written.
  void Finish();

 private:
  void WriteLine(const FrameResult& result);

  const std::filesystem::path dir_;
  std::deque<std::int64_t> due_;  // frames to be shown, ascending
  std::int64_t num_frames_ = 0;
  std::ofstream file_;
};

}  // namespace terrace
