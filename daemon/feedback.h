// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>

#include "core/time.h"

namespace terrace {

/// Carries what the map learnt from one frame, a plain struct of the folder that receives it, to an earlier
/// stage with a fixed lag in frames, so that the map is the same for any number of threads: frame k uses what
/// frame k - lag taught, whether that came long ago or must be waited for. Where nobody may wait, what is not
/// there in time is skipped and counted.
template <typename Lesson>
class FeedbackExchange {
 public:
  FeedbackExchange(int lag_frames, bool wait) : lag_frames_(lag_frames), wait_(wait) {}

  /// Called once for every frame, in order, also when it taught nothing.
  void Post(FrameId frame_id, Lesson lesson) {
    const std::lock_guard lock(mutex_);
    posted_[frame_id] = std::move(lesson);
    posted_any_.notify_all();
  }

  /// What frame `frame_id` may use. Called once for every frame, in order. Empty for the first frames, where
  /// it is late and nobody may wait, and after Close().
  Lesson Take(FrameId frame_id) {
    std::unique_lock lock(mutex_);
    const FrameId source = frame_id - lag_frames_;
    if (source < 0) return {};
    if (wait_) posted_any_.wait(lock, [&] { return closed_ || posted_.contains(source); });
    const auto found = posted_.find(source);
    Lesson lesson{};
    if (found != posted_.end()) {
      lesson = std::move(found->second);
    } else {
      ++num_skipped_;
    }
    posted_.erase(posted_.begin(), posted_.upper_bound(source));
    return lesson;
  }

  /// Frames that had to do without.
  std::int64_t num_skipped() const {
    const std::lock_guard lock(mutex_);
    return num_skipped_;
  }

  /// Nobody is left waiting.
  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    posted_any_.notify_all();
  }

 private:
  const int lag_frames_;
  const bool wait_;
  mutable std::mutex mutex_;
  std::condition_variable posted_any_;
  std::map<FrameId, Lesson> posted_;
  std::int64_t num_skipped_ = 0;
  bool closed_ = false;
};

}  // namespace terrace
