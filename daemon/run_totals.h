// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/explanation.h"
#include "core/pose_estimate.h"
#include "core/stage_meter.h"

namespace terrace {

/// What only the end of a run knows.
struct RunTotals {
  std::int64_t num_dropped = 0;          ///< frames that came in and have no pose
  std::int64_t num_passed_over = 0;      ///< frames with a pose that the map had no time for
  std::int64_t num_lessons_skipped = 0;  ///< what the map had learnt and an earlier stage did not wait for
  double wall_s = 0.0;
  bool realtime = false;  ///< frames came at their own pace, and the newest won
  Gravity gravity;
  std::vector<StageCost> stages;
  Explanations explanations;  ///< of the map at the end
};

}  // namespace terrace
