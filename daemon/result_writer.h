// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "daemon/pipeline.h"
#include "daemon/run_totals.h"
#include "results/camera_file.h"

namespace terrace {

/// The output folder cannot be used; what() is one sentence.
class OutputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Makes `dir` ready to be written into: it must be empty or absent unless `overwrite`, which removes the
/// results of an earlier run (and nothing else). Throws OutputError.
void PrepareOutputFolder(const std::filesystem::path& dir, bool overwrite);

/// Writes the result files (results/) into a folder: lines as frames come, the rest at the end. Throws
/// OutputError when the disk refuses.
class ResultWriter {
 public:
  /// @param save_disparity_every  0: none, N: frames 0, N, 2N, ...
  ResultWriter(const std::filesystem::path& dir, const ResultCamera& camera, int save_disparity_every);

  /// @param latency_ms  none unless frames came at their recorded times
  void AddFrame(const FrameResult& result, std::optional<double> latency_ms);
  void Finish(const RunTotals& totals);

  std::int64_t num_frames() const { return num_frames_; }
  std::int64_t num_tracking() const { return num_tracking_; }
  std::int64_t num_bridging() const { return num_bridging_; }
  std::int64_t num_lost() const { return num_lost_; }
  const TerrainMapPtr& map() const { return map_; }

 private:
  void WriteDisparity(const DisparityImage& disparity) const;
  void AddStaircases(const MapChange& change);

  const std::filesystem::path dir_;
  const int save_disparity_every_;
  std::ofstream trajectory_;
  std::ofstream frames_;
  std::ofstream staircases_;
  std::map<std::int64_t, std::string> staircase_lines_;  // as last written
  std::int64_t num_frames_ = 0;
  std::int64_t num_tracking_ = 0;
  std::int64_t num_bridging_ = 0;
  std::int64_t num_lost_ = 0;
  std::int64_t map_cells_ = 0;
  std::int64_t map_bytes_ = 0;
  Series latency_ms_;
  TerrainMapPtr map_;
};

}  // namespace terrace
