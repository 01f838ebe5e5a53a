// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "core/bounded_queue.h"

namespace terrace {

/// A thread that takes items from one queue, works on them in order and hands the results to the next stage.
/// It ends when its input is closed and empty, and calls `at_end` then (usually: close the next queue). A
/// step that throws ends the stage: the input is closed, `at_end` is called and Join() throws what the step
/// threw.
template <typename In>
class Stage {
 public:
  /// @param step  works on one item; false: nobody wants more, the stage ends
  Stage(BoundedQueue<In>* input, std::function<bool(In)> step, std::function<void()> at_end)
      : input_(input), step_(std::move(step)), at_end_(std::move(at_end)), thread_([this] { Run(); }) {}

  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  ~Stage() {
    if (thread_.joinable()) {
      input_->Close();
      thread_.join();
    }
  }

  /// Waits for the end and rethrows what a step threw.
  void Join() {
    if (thread_.joinable()) thread_.join();
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

 private:
  void Run() {
    try {
      while (std::optional<In> item = input_->Pop()) {
        if (!step_(std::move(*item))) break;
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    input_->Close();
    at_end_();
  }

  BoundedQueue<In>* const input_;
  const std::function<bool(In)> step_;
  const std::function<void()> at_end_;
  std::exception_ptr failure_;  // written by the thread, read after joining it
  std::thread thread_;          // last: starts when everything above stands
};

}  // namespace terrace
