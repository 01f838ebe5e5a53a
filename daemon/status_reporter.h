// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include <lcm/lcm-cpp.hpp>

#include "core/status.h"
#include "daemon/pipeline.h"

namespace terrace {

/// Sums up what the daemon says about itself, window by window, and sends it. Every function may be called
/// from any thread. `lcm` must outlive it.
class StatusReporter {
 public:
  StatusReporter(lcm::LCM* lcm, std::string channel, InputSource source, std::string config_hash,
                 double deadline_ms);

  void AddFrameIn();
  void AddPose(const PoseEstimate& pose);
  /// A frame whose map is out.
  void AddResult(const FrameResult& result);

  /// The status over the window since the last call, but for what only the input knows. Tracking trouble,
  /// when there is any, makes a running daemon a degraded one.
  Status Take(DaemonState state, StageMeters* meters);
  void Send(const Status& status);
  /// Whether a status that has come over the bus is one of ours.
  bool HasSent(Timestamp t) const { return std::find(sent_.begin(), sent_.end(), t) != sent_.end(); }

 private:
  lcm::LCM* const lcm_;
  const std::string channel_;
  const std::string config_hash_;
  const InputSource source_;
  const double deadline_ms_;
  const std::chrono::steady_clock::time_point start_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point window_start_;
  double cpu_s_ = 0.0;
  std::int64_t seq_ = 0;
  std::int64_t num_in_ = 0;
  std::int64_t num_out_ = 0;
  std::vector<double> ages_ms_;
  std::int64_t num_deadline_missed_ = 0;
  std::int64_t num_lost_ = 0;
  PoseEstimate last_pose_;
  FrameResult last_;
  std::deque<Timestamp> sent_;  ///< of the newest
};

}  // namespace terrace
