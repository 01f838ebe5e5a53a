// SPDX-License-Identifier: BSD-3-Clause
#include "core/stage_meter.h"

#include <chrono>

namespace terrace {
namespace {

std::int64_t WallNs() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

}  // namespace

const char* Name(StageId stage) {
  static constexpr std::array<const char*, kNumStages> kNames{"load",     "rectify",       "disparity",
                                                              "odometry", "decomposition", "modelling",
                                                              "merging",  "labels",        "publish"};
  return kNames[static_cast<std::size_t>(stage)];
}

void StageMeter::Add(std::int64_t wall_ns, std::int64_t caller_cpu_ns) {
  const double wall_ms = static_cast<double>(wall_ns) * 1e-6;
  const std::lock_guard lock(mutex_);
  wall_ms_.Add(wall_ms);
  window_ms_.Add(wall_ms);
  last_ms_ = wall_ms;
  caller_cpu_ms_ += static_cast<double>(caller_cpu_ns) * 1e-6;
}

StageCost StageMeter::CostOf(StageId stage) const {
  const std::lock_guard lock(mutex_);
  const auto count = wall_ms_.count();
  const double cpu_ms = caller_cpu_ms_ + static_cast<double>(helpers_.helper_ns()) * 1e-6;
  return {Name(stage), count, count == 0 ? 0.0 : cpu_ms / static_cast<double>(count), wall_ms_.quantiles()};
}

StageStatus StageMeter::TakeWindow(StageId stage) {
  const std::lock_guard lock(mutex_);
  const Quantiles quantiles = window_ms_.quantiles();
  StageStatus status;
  status.name = Name(stage);
  status.num_in = status.num_out = wall_ms_.count();
  status.last_ms = last_ms_;
  status.p50_ms = quantiles.p50;
  status.p99_ms = quantiles.p99;
  status.max_ms = quantiles.max;
  window_ms_ = Series(kWindowCapacity);
  return status;
}

std::vector<StageCost> StageMeters::costs() const {
  std::vector<StageCost> costs;
  for (int i = 0; i < kNumStages; ++i)
    costs.push_back(meters_[static_cast<std::size_t>(i)].CostOf(static_cast<StageId>(i)));
  return costs;
}

std::vector<StageStatus> StageMeters::TakeWindows() {
  std::vector<StageStatus> windows;
  for (int i = 0; i < kNumStages; ++i)
    windows.push_back(meters_[static_cast<std::size_t>(i)].TakeWindow(static_cast<StageId>(i)));
  return windows;
}

StageMeasurement::StageMeasurement(StageMeters* meters, StageId stage) : meters_(meters) { Start(stage); }
StageMeasurement::~StageMeasurement() { Stop(); }

void StageMeasurement::Next(StageId stage) {
  Stop();
  Start(stage);
}

void StageMeasurement::Start(StageId stage) {
  meter_ = &(*meters_)[stage];
  account_.emplace(meter_->helpers());
  wall_ns_ = WallNs();
  cpu_ns_ = ThreadCpuNs();
}

void StageMeasurement::Stop() {
  meter_->Add(WallNs() - wall_ns_, ThreadCpuNs() - cpu_ns_);
  account_.reset();
}

}  // namespace terrace
