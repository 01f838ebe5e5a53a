// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

#include "core/time.h"

namespace terrace {

/// Carries what the map learnt from one frame, a plain struct of the folder that receives it, to an earlier
/// stage with a fixed lag in frames, so that the map is the same for any number of threads: frame k uses what
/// frame k - lag taught, whether that came long ago or must be waited for.
template <typename Lesson>
class FeedbackExchange {
 public:
  explicit FeedbackExchange(int lag_frames) : lag_frames_(lag_frames) {}

  /// Called once for every frame, in order, also when it taught nothing.
  void Post(FrameId frame_id, Lesson lesson) {
    const std::lock_guard lock(mutex_);
    posted_[frame_id] = std::move(lesson);
    posted_any_.notify_all();
  }

  /// What frame `frame_id` may use; waits until it is there. Called once for every frame, in order. Empty for
  /// the first frames and after Close().
  Lesson Take(FrameId frame_id) {
    std::unique_lock lock(mutex_);
    const FrameId source = frame_id - lag_frames_;
    if (source < 0) return {};
    posted_any_.wait(lock, [&] { return closed_ || posted_.contains(source); });
    const auto found = posted_.find(source);
    if (found == posted_.end()) return {};
    Lesson lesson = std::move(found->second);
    posted_.erase(posted_.begin(), std::next(found));
    return lesson;
  }

  /// Nobody is left waiting.
  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    posted_any_.notify_all();
  }

 private:
  const int lag_frames_;
  std::mutex mutex_;
  std::condition_variable posted_any_;
  std::map<FrameId, Lesson> posted_;
  bool closed_ = false;
};

}  // namespace terrace
