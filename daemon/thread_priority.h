// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace terrace {

/// From here on the calling thread yields the processor to the threads of the pose, which are few and short. Where the
/// system has no such thing, nothing changes.
void YieldToThePose();

/// While it lives, TBB's own threads, which only disparity and map use, do the same. The thread that makes it does not.
class WorkersYieldToThePose {
 public:
  WorkersYieldToThePose();
  ~WorkersYieldToThePose();
  WorkersYieldToThePose(const WorkersYieldToThePose&) = delete;
  WorkersYieldToThePose& operator=(const WorkersYieldToThePose&) = delete;

 private:
  class Observer;
  const std::unique_ptr<Observer> observer_;
};

}  // namespace terrace
