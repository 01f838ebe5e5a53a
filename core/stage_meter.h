// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/cpu_account.h"
#include "core/statistics.h"
#include "core/status.h"

namespace terrace {

/// The steps of a frame, in their order.
enum class StageId {
  kLoad,
  kRectify,
  kDisparity,
  kOdometry,
  kDecomposition,
  kModelling,
  kMerging,
  kLabels,
  kPublish,
};
inline constexpr int kNumStages = 9;
const char* Name(StageId stage);  ///< "load", "rectify", ...

/// What one stage cost since the start.
struct StageCost {
  std::string name;
  std::int64_t count = 0;
  double cpu_ms_mean = 0.0;  ///< of all threads that worked for the stage
  Quantiles wall_ms;
};

/// Wall and CPU time of one stage. From any thread.
class StageMeter {
 public:
  void Add(std::int64_t wall_ns, std::int64_t caller_cpu_ns);
  /// Where the time of threads that help the stage is booked.
  CpuAccount* helpers() { return &helpers_; }

  StageCost CostOf(StageId stage) const;
  /// Over the time since the last call.
  StageStatus TakeWindow(StageId stage);

 private:
  CpuAccount helpers_;
  mutable std::mutex mutex_;
  Series wall_ms_;
  double caller_cpu_ms_ = 0.0;
  Series window_ms_{kWindowCapacity};
  double last_ms_ = 0.0;

  static constexpr std::size_t kWindowCapacity = 4096;
};

/// The meters of all stages.
class StageMeters {
 public:
  StageMeter& operator[](StageId stage) { return meters_[static_cast<std::size_t>(stage)]; }
  std::vector<StageCost> costs() const;
  std::vector<StageStatus> TakeWindows();

 private:
  std::array<StageMeter, kNumStages> meters_;
};

/// Measures the stage that the calling thread is in, until the end of the scope or the next stage, with the
/// CPU time of every thread that helps it by ParallelFor.
class StageMeasurement {
 public:
  StageMeasurement(StageMeters* meters, StageId stage);
  ~StageMeasurement();
  StageMeasurement(const StageMeasurement&) = delete;
  StageMeasurement& operator=(const StageMeasurement&) = delete;

  /// Ends the stage at hand and begins another.
  void Next(StageId stage);

 private:
  void Start(StageId stage);
  void Stop();

  StageMeters* const meters_;
  StageMeter* meter_ = nullptr;
  std::optional<CpuAccount::Scope> account_;
  std::int64_t wall_ns_ = 0;
  std::int64_t cpu_ns_ = 0;
};

}  // namespace terrace
