// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/stage_meter.h"

#include <chrono>
#include <ctime>
#include <utility>

#include "core/check.h"

#ifdef TERRACE_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

namespace terrace {
namespace {

std::int64_t ThreadCpuNs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

std::int64_t WallNs() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

// When a helper entered the arena it now works in. A thread helps one arena at a time.
thread_local std::int64_t helper_entered_cpu_ns = 0;

}  // namespace

StageMeter::StageMeter(std::string name) : name_(std::move(name)), helpers_(&arena_) {}
StageMeter::~StageMeter() = default;

// Like core/parallel_for.cpp: in a build for the thread sanitizer this file is not instrumented, since TBB's
// threads call it, and tells the sanitizer that a step, which TBB may hand to another thread, starts here and
// ends here.
void StageMeter::RunInArena(const std::function<void()>& step) {
#ifdef TERRACE_SANITIZE_THREAD
  char start = 0, end = 0;
  __tsan_release(&start);
  arena_.execute([&] {
    __tsan_acquire(&start);
    step();
    __tsan_release(&end);
  });
  __tsan_acquire(&end);
#else
  arena_.execute(step);
#endif
}

void StageMeter::HelperClock::on_scheduler_entry(bool is_worker) {
  if (is_worker) helper_entered_cpu_ns = ThreadCpuNs();
}

void StageMeter::HelperClock::on_scheduler_exit(bool is_worker) {
  if (is_worker) helper_ns_ += ThreadCpuNs() - helper_entered_cpu_ns;
}

StageMeter::Measurement::Measurement(StageMeter* meter)
    : meter_(meter), wall_ns_(WallNs()), cpu_ns_(ThreadCpuNs()) {}

StageMeter::Measurement::~Measurement() {
  const double wall_ms = static_cast<double>(WallNs() - wall_ns_) * 1e-6;
  const double cpu_ms = static_cast<double>(ThreadCpuNs() - cpu_ns_) * 1e-6;
  const std::lock_guard lock(meter_->mutex_);
  meter_->wall_ms_.Add(wall_ms);
  meter_->window_ms_.Add(wall_ms);
  meter_->last_ms_ = wall_ms;
  meter_->caller_cpu_ms_ += cpu_ms;
}

StageCost StageMeter::cost() const {
  const std::lock_guard lock(mutex_);
  const auto count = wall_ms_.count();
  const double cpu_ms = caller_cpu_ms_ + helpers_.helper_ms();
  return {name_, count, count == 0 ? 0.0 : cpu_ms / static_cast<double>(count), wall_ms_.quantiles()};
}

StageStatus StageMeter::TakeWindow() {
  const std::lock_guard lock(mutex_);
  const Quantiles quantiles = window_ms_.quantiles();
  StageStatus status;
  status.name = name_;
  status.num_in = status.num_out = wall_ms_.count();
  status.last_ms = last_ms_;
  status.p50_ms = quantiles.p50;
  status.p99_ms = quantiles.p99;
  status.max_ms = quantiles.max;
  window_ms_ = Series(4096);
  return status;
}

StageMeters::StageMeters()
    : order_{"load",      "rectify", "disparity", "odometry", "decomposition",
             "modelling", "merging", "labels",    "publish"} {
  for (const std::string& name : order_) meters_[name] = std::make_unique<StageMeter>(name);
}

StageMeter& StageMeters::operator[](const std::string& name) {
  const auto found = meters_.find(name);
  TERRACE_CHECK(found != meters_.end(), name);
  return *found->second;
}

std::vector<StageCost> StageMeters::costs() const {
  std::vector<StageCost> costs;
  for (const std::string& name : order_) costs.push_back(meters_.at(name)->cost());
  return costs;
}

std::vector<StageStatus> StageMeters::TakeWindows() {
  std::vector<StageStatus> windows;
  for (const std::string& name : order_) windows.push_back(meters_.at(name)->TakeWindow());
  return windows;
}

}  // namespace terrace
