// SPDX-License-Identifier: BSD-3-Clause
#include "core/stage_meter.h"

#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "core/parallel_for.h"

namespace terrace {
namespace {

/// Works until this thread has used so much CPU time.
void Burn(double cpu_ms) {
  const std::int64_t end_ns = ThreadCpuNs() + static_cast<std::int64_t>(cpu_ms * 1e6);
  while (ThreadCpuNs() < end_ns) {
  }
}

const StageCost& CostOf(const std::vector<StageCost>& costs, StageId stage) {
  return costs[static_cast<std::size_t>(stage)];
}

TEST(StageMeterTest, GivesEachStageTheTimeFromItsBeginningToTheNextOne) {
  StageMeters meters;
  {
    StageMeasurement measuring(&meters, StageId::kDecomposition);
    Burn(4.0);
    measuring.Next(StageId::kModelling);
    Burn(8.0);
  }
  const std::vector<StageCost> costs = meters.costs();
  EXPECT_EQ(CostOf(costs, StageId::kDecomposition).count, 1);
  EXPECT_GE(CostOf(costs, StageId::kDecomposition).cpu_ms_mean, 4.0);
  EXPECT_GE(CostOf(costs, StageId::kModelling).cpu_ms_mean, 8.0);
  EXPECT_GE(CostOf(costs, StageId::kModelling).wall_ms.max, 8.0);
  EXPECT_EQ(CostOf(costs, StageId::kLabels).count, 0);
}

TEST(StageMeterTest, CountsTheTimeOfThreadsThatHelp) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  StageMeters meters;
  constexpr int kPieces = 16;
  {
    const StageMeasurement measuring(&meters, StageId::kDisparity);
    ParallelFor(kPieces, [](int) { Burn(2.0); });
  }
  EXPECT_GE(CostOf(meters.costs(), StageId::kDisparity).cpu_ms_mean, kPieces * 2.0);
}

TEST(StageMeterTest, KeepsApartWhatTwoThreadsMeasureAtOnce) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  StageMeters meters;
  const auto work = [&meters](StageId stage, int pieces) {
    const StageMeasurement measuring(&meters, stage);
    ParallelFor(pieces, [](int) { Burn(2.0); });
  };
  std::thread odometry(work, StageId::kOdometry, 4);
  work(StageId::kDisparity, 8);
  odometry.join();
  const std::vector<StageCost> costs = meters.costs();
  EXPECT_GE(CostOf(costs, StageId::kOdometry).cpu_ms_mean, 8.0);
  EXPECT_GE(CostOf(costs, StageId::kDisparity).cpu_ms_mean, 16.0);
}

TEST(StageMeterTest, AWindowHoldsWhatCameSinceTheLastOne) {
  StageMeters meters;
  { const StageMeasurement measuring(&meters, StageId::kLoad); }
  { const StageMeasurement measuring(&meters, StageId::kLoad); }
  std::vector<StageStatus> windows = meters.TakeWindows();
  ASSERT_EQ(windows.size(), static_cast<std::size_t>(kNumStages));
  EXPECT_EQ(windows.front().name, "load");
  EXPECT_EQ(windows.front().num_out, 2);
  EXPECT_GT(windows.front().max_ms, 0.0);
  windows = meters.TakeWindows();
  EXPECT_EQ(windows.front().num_out, 2) << "counts run from the start";
  EXPECT_EQ(windows.front().max_ms, 0.0);
}

}  // namespace
}  // namespace terrace
