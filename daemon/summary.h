// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/result_writer.h"
#include "datasets/sequence.h"

namespace terrace {

/// What a person wants to know after a replay, on standard output: frames and how they were tracked, drift
/// when there is truth, what the map holds, speed, and where the results lie.
class RunSummary {
 public:
  explicit RunSummary(const SequenceInfo& info) : info_(info) {}

  void AddFrame(const FrameResult& result);
  void Print(const ResultWriter& writer, const RunTotals& totals, const std::filesystem::path& output) const;

 private:
  const SequenceInfo info_;
  std::vector<std::string> troubles_;  // when tracking was lost or found again
  TrackingStatus last_status_ = TrackingStatus::kTracking;
};

}  // namespace terrace
