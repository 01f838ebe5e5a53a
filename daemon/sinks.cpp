// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/sinks.h"

#include <chrono>
#include <string>

#include <spdlog/spdlog.h>

namespace terrace {

void WarningLog::AddFrame(const FrameResult& result) {
  for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
}

void RequestSink::AddFrame(const FrameResult& result) {
  AnswerSources sources;
  sources.map = result.change.map;
  sources.map_id = publisher_->map_id();
  sources.camera = &pipeline_->camera();
  sources.octree = &pipeline_->octree();
  sources.disparity = result.disparity;
  if (result.pose.status != TrackingStatus::kLost) sources.T_world_left = result.pose.T_world_left;
  desk_->Answer(sources, std::chrono::steady_clock::now());
}

void ReplayReport::AddFrame(const FrameResult& result) {
  summary_.AddFrame(result);
  progress_->Update(files_->writer().num_frames(), Name(result.pose.status));
}

void ReplayReport::Finish(const RunTotals& totals) {
  progress_.reset();
  summary_.Print(files_->writer(), totals, output_);
}

}  // namespace terrace
