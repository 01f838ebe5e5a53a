// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "core/check.h"

namespace terrace {

enum class WhenFull {
  kWait,        ///< the producer waits: nothing is lost (replay)
  kDropOldest,  ///< the newest wins, what fell out is counted (live)
};

/// A queue between two threads with a capacity, a rule for being full and a count of what it dropped.
/// Closing it wakes everyone; what is inside can still be taken out.
template <typename T>
class BoundedQueue {
 public:
  /// Called with an item that is dropped and the one that will be taken in its place, to save what must not
  /// be lost.
  using OnDrop = std::function<void(T dropped, T* next)>;

  BoundedQueue(std::size_t capacity, WhenFull when_full, OnDrop on_drop = nullptr)
      : capacity_(capacity), when_full_(when_full), on_drop_(std::move(on_drop)) {
    TERRACE_CHECK(capacity > 0);
  }

  /// False when the queue is closed: the item is gone and the producer should end.
  bool Push(T item) {
    std::unique_lock lock(mutex_);
    if (when_full_ == WhenFull::kWait) {
      not_full_.wait(lock, [&] { return closed_ || items_.size() < capacity_; });
    } else if (items_.size() >= capacity_ && !closed_) {
      T dropped = std::move(items_.front());
      items_.pop_front();
      ++num_dropped_;
      if (on_drop_) on_drop_(std::move(dropped), items_.empty() ? &item : &items_.front());
    }
    if (closed_) return false;
    items_.push_back(std::move(item));
    not_empty_.notify_one();
    return true;
  }

  /// Waits for the next item; none when the queue is closed and empty.
  std::optional<T> Pop() {
    std::unique_lock lock(mutex_);
    not_empty_.wait(lock, [&] { return closed_ || !items_.empty(); });
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    not_full_.notify_one();
    return item;
  }

  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    not_empty_.notify_all();
    not_full_.notify_all();
  }

  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return items_.size();
  }

  std::int64_t num_dropped() const {
    const std::lock_guard lock(mutex_);
    return num_dropped_;
  }

 private:
  const std::size_t capacity_;
  const WhenFull when_full_;
  const OnDrop on_drop_;
  mutable std::mutex mutex_;
  std::condition_variable not_empty_;
  std::condition_variable not_full_;
  std::deque<T> items_;
  std::int64_t num_dropped_ = 0;
  bool closed_ = false;
};

}  // namespace terrace
