// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/replay.h"

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include "daemon/interrupt.h"
#include "daemon/pipeline.h"
#include "daemon/progress.h"
#include "daemon/result_writer.h"
#include "daemon/self_mask.h"
#include "daemon/summary.h"
#include "daemon/threaded_pipeline.h"
#include "datasets/sequence.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

/// When each frame was handed over, so that its latency is known when its map is out.
class HandoverTimes {
 public:
  void Add(Timestamp t_capture) {
    const std::lock_guard lock(mutex_);
    times_.emplace_back(t_capture, Clock::now());
  }

  double LatencyMs(Timestamp t_capture) {
    const std::lock_guard lock(mutex_);
    while (!times_.empty() && times_.front().first < t_capture) times_.pop_front();  // dropped ones
    if (times_.empty() || times_.front().first != t_capture) return 0.0;
    return std::chrono::duration<double, std::milli>(Clock::now() - times_.front().second).count();
  }

 private:
  std::mutex mutex_;
  std::deque<std::pair<Timestamp, Clock::time_point>> times_;
};

/// Sleeps until the frame's recorded distance from the first one has passed; false when interrupted.
bool WaitForRecordedTime(Clock::time_point start, Timestamp t_first, Timestamp t_capture) {
  const auto due = start + (t_capture - t_first);
  while (Clock::now() < due) {
    if (Interrupted()) return false;
    std::this_thread::sleep_for(std::min<Clock::duration>(due - Clock::now(), std::chrono::milliseconds(50)));
  }
  return true;
}

}  // namespace

void RunReplay(const ReplayOptions& options, const Config& config) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(options.num_threads));
  const std::unique_ptr<Sequence> sequence = OpenSequence(options.sequence);
  const SequenceInfo& info = sequence->info();
  for (const std::string& warning : info.warnings) spdlog::warn("{}", warning);

  Pipeline pipeline(config.pipeline, info.calibration,
                    LoadSelfMask(config.pipeline.robot.self_mask_png, info.calibration));
  PrepareOutputFolder(options.output, options.overwrite);
  ResultWriter writer(options.output, {pipeline.camera(), pipeline.R_rect_raw(), pipeline.T_body_left()},
                      options.save_disparity_every);
  RunSummary summary(info);
  Progress progress(info.num_frames);
  HandoverTimes handovers;
  const auto start = Clock::now();

  const auto sink = [&](const SensorFrame&, const FrameResult& result) {
    pipeline.meters()["publish"].Run([&] {
      const auto latency_ms =
          options.realtime ? std::optional(handovers.LatencyMs(result.pose.t_capture)) : std::nullopt;
      writer.AddFrame(result, latency_ms);
    });
    summary.AddFrame(result);
    progress.Update(writer.num_frames(), Name(result.pose.status));
  };
  const auto next_frame = [&]() -> std::optional<SensorFrame> {
    if (Interrupted()) return std::nullopt;
    return pipeline.meters()["load"].Run([&] { return sequence->Next(); });
  };

  std::int64_t num_dropped = 0;
  if (options.num_threads == 1 && !options.realtime) {
    while (std::optional<SensorFrame> sensors = next_frame()) sink(*sensors, pipeline.Process(*sensors));
  } else {
    ThreadedPipeline threads(&pipeline, options.realtime ? WhenFull::kDropOldest : WhenFull::kWait, sink);
    while (std::optional<SensorFrame> sensors = next_frame()) {
      if (options.realtime && !WaitForRecordedTime(start, info.t_first, sensors->pair.t_capture)) break;
      handovers.Add(sensors->pair.t_capture);
      if (!threads.Push(std::move(*sensors))) break;
    }
    threads.Finish();
    num_dropped = threads.num_dropped();
  }
  if (Interrupted()) spdlog::warn("interrupted: the results hold what was read until then");

  RunTotals totals;
  totals.num_dropped = num_dropped + sequence->num_time_jumps();
  totals.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  totals.realtime = options.realtime;
  totals.gravity = pipeline.gravity();
  totals.stages = pipeline.meters().costs();
  writer.Finish(totals);
  summary.Print(writer, totals, options.output);
}

}  // namespace terrace
