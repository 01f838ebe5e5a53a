// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <deque>
#include <mutex>
#include <utility>

#include "core/time.h"

namespace terrace {

/// When each frame was handed over, so that its latency is known when its map is out. From any thread.
class HandoverTimes {
 public:
  void Add(Timestamp t_capture) {
    const std::lock_guard lock(mutex_);
    times_.emplace_back(t_capture, std::chrono::steady_clock::now());
  }

  /// Of the frame with this time; what is older was dropped and is forgotten.
  double LatencyMs(Timestamp t_capture) {
    const std::lock_guard lock(mutex_);
    while (!times_.empty() && times_.front().first < t_capture) times_.pop_front();
    if (times_.empty() || times_.front().first != t_capture) return 0.0;
    const auto latency = std::chrono::steady_clock::now() - times_.front().second;
    return std::chrono::duration<double, std::milli>(latency).count();
  }

 private:
  std::mutex mutex_;
  std::deque<std::pair<Timestamp, std::chrono::steady_clock::time_point>> times_;
};

}  // namespace terrace
