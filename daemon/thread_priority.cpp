// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/thread_priority.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <tbb/task_scheduler_observer.h>
#include <unistd.h>

namespace terrace {
namespace {

// Each step is about a quarter less of the processor where two want it: with ten the pose has nine tenths. Going down
// needs no rights, so no thread has to go up.
constexpr int kSteps = 10;

}  // namespace

void YieldToThePose() {
  thread_local bool done = false;
  if (done) return;
  done = true;
  // On Linux a thread has a nice value of its own, known by its kernel id.
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  const int now = getpriority(PRIO_PROCESS, thread);
  setpriority(PRIO_PROCESS, thread, now + kSteps);
}

class WorkersYieldToThePose::Observer : public tbb::task_scheduler_observer {
 public:
  Observer() { observe(true); }
  ~Observer() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) YieldToThePose();
  }
};

WorkersYieldToThePose::WorkersYieldToThePose() : observer_(std::make_unique<Observer>()) {}
WorkersYieldToThePose::~WorkersYieldToThePose() = default;

}  // namespace terrace
