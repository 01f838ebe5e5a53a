// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/sinks.h"

#include <string>

#include <spdlog/spdlog.h>

namespace terrace {

void WarningLog::AddFrame(const FrameResult& result) {
  for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
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
