// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include "core/statistics.h"
#include "core/status.h"

namespace terrace {

/// What one stage cost since the start.
struct StageCost {
  std::string name;
  std::int64_t count = 0;
  double cpu_ms_mean = 0.0;  ///< of all threads that worked for the stage
  Quantiles wall_ms;
};

/// Runs a stage's step and measures it: wall time, and the CPU time of every thread that worked on it. Each
/// stage has an arena of its own, so that the time of TBB's helpers goes to the stage that they helped.
class StageMeter {
 public:
  explicit StageMeter(std::string name);
  ~StageMeter();
  StageMeter(const StageMeter&) = delete;
  StageMeter& operator=(const StageMeter&) = delete;

  template <typename Step>
  auto Run(const Step& step) {
    const Measurement measurement(this);
    if constexpr (std::is_void_v<decltype(step())>) {
      RunInArena(step);
    } else {
      std::optional<decltype(step())> result;
      RunInArena([&] { result.emplace(step()); });
      return *std::move(result);
    }
  }

  StageCost cost() const;
  /// Over the time since the last call.
  StageStatus TakeWindow();

 private:
  class HelperClock : public tbb::task_scheduler_observer {
   public:
    explicit HelperClock(tbb::task_arena* arena) : tbb::task_scheduler_observer(*arena) { observe(true); }
    ~HelperClock() override { observe(false); }
    void on_scheduler_entry(bool is_worker) override;
    void on_scheduler_exit(bool is_worker) override;
    double helper_ms() const { return static_cast<double>(helper_ns_.load()) * 1e-6; }

   private:
    std::atomic<std::int64_t> helper_ns_{0};
  };

  class Measurement {
   public:
    explicit Measurement(StageMeter* meter);
    ~Measurement();

   private:
    StageMeter* meter_;
    std::int64_t wall_ns_;
    std::int64_t cpu_ns_;
  };

  void RunInArena(const std::function<void()>& step);

  const std::string name_;
  tbb::task_arena arena_;
  HelperClock helpers_;
  mutable std::mutex mutex_;
  Series wall_ms_;
  double caller_cpu_ms_ = 0.0;
  Series window_ms_{4096};
  double last_ms_ = 0.0;
};

/// The stages of DESIGN.md in their order: load rectify disparity odometry decomposition modelling merging
/// labels publish.
class StageMeters {
 public:
  StageMeters();
  StageMeter& operator[](const std::string& name);
  std::vector<StageCost> costs() const;
  std::vector<StageStatus> TakeWindows();

 private:
  std::vector<std::string> order_;
  std::map<std::string, std::unique_ptr<StageMeter>> meters_;
};

}  // namespace terrace
