// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/pose_estimate.h"
#include "daemon/pipeline.h"
#include "daemon/run_totals.h"

namespace terrace {

/// Takes what the mapper makes of frames: files, messages, a status, a summary.
class FrameSink {
 public:
  virtual ~FrameSink() = default;

  /// Each frame, in order, as soon as its pose is known and before its map is. In the thread of the odometry,
  /// which is not to be held up.
  virtual void AddPose(const PoseEstimate& /*pose*/) {}
  /// Each frame, in order, once its map is there or is known not to come. In the thread of the map.
  virtual void AddFrame(const FrameResult& result) = 0;
  /// After the last frame.
  virtual void Finish(const RunTotals& /*totals*/) {}
};

}  // namespace terrace
