// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/replay.h"

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include <lcm/lcm-cpp.hpp>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include "daemon/handover_times.h"
#include "daemon/interrupt.h"
#include "daemon/pipeline.h"
#include "daemon/progress.h"
#include "daemon/result_writer.h"
#include "daemon/self_mask.h"
#include "daemon/status_reporter.h"
#include "daemon/summary.h"
#include "daemon/terrain_publisher.h"
#include "daemon/threaded_pipeline.h"
#include "daemon/track_writer.h"
#include "datasets/sequence.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

/// Sleeps until the frame's recorded distance from the first one has passed; false when interrupted.
bool WaitForRecordedTime(Clock::time_point start, Timestamp t_first, Timestamp t_capture) {
  const auto due = start + (t_capture - t_first);
  while (Clock::now() < due) {
    if (Interrupted()) return false;
    std::this_thread::sleep_for(std::min<Clock::duration>(due - Clock::now(), std::chrono::milliseconds(50)));
  }
  return true;
}

/// Publishes a replay as the live daemon would: every frame, and a status once a second.
class ReplayPublisher {
 public:
  ReplayPublisher(const std::string& url, const Config& config, Pipeline* pipeline)
      : pipeline_(pipeline),
        lcm_(url),
        publisher_(&lcm_, config.channels, pipeline->T_body_left(), config.live.snapshot_period_s),
        reporter_(InputSource::kReplay, ConfigHash(config), config.live.deadline_ms) {
    if (!lcm_.good()) throw std::runtime_error("--publish " + url + ": cannot be opened");
  }

  void Publish(const FrameResult& result, std::optional<double> latency_ms) {
    publisher_.Publish(result.pose, result.change.map);
    reporter_.AddFrameIn();
    reporter_.AddResult(result, latency_ms.value_or(0.0));
    if (Clock::now() < status_due_) return;
    status_due_ = Clock::now() + std::chrono::seconds(1);
    publisher_.Publish(reporter_.Take(DaemonState::kRunning, &pipeline_->meters()));
  }

  /// For subscribers that missed the last change.
  void Finish() {
    publisher_.SendSnapshot();
    publisher_.Publish(reporter_.Take(DaemonState::kStopping, &pipeline_->meters()));
  }

 private:
  Pipeline* const pipeline_;
  lcm::LCM lcm_;
  TerrainPublisher publisher_;
  StatusReporter reporter_;
  Clock::time_point status_due_;
};

}  // namespace

void RunReplay(const ReplayOptions& options, const Config& config) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(options.num_threads));
  const std::unique_ptr<Sequence> sequence = OpenSequence(options.sequence);
  const SequenceInfo& info = sequence->info();
  for (const std::string& warning : info.warnings) spdlog::warn("{}", warning);

  Pipeline pipeline(config.pipeline, info.calibration,
                    LoadSelfMask(config.pipeline.terrain.robot.self_mask_png,
                                 RectifiedSize(info.calibration, config.pipeline.rectifier)));
  PrepareOutputFolder(options.output, options.overwrite);
  ResultWriter writer(options.output, {pipeline.camera(), pipeline.R_rect_raw(), pipeline.T_body_left()},
                      options.save_disparity_every);
  std::optional<TrackWriter> tracks;
  if (options.num_track_pictures > 0)
    tracks.emplace(options.output, options.num_track_pictures, info.num_frames);
  RunSummary summary(info);
  std::optional<ReplayPublisher> publisher;
  if (!options.publish_url.empty()) publisher.emplace(options.publish_url, config, &pipeline);
  Progress progress(info.num_frames);
  HandoverTimes handovers;
  const auto start = Clock::now();

  const auto sink = [&](const SensorFrame&, const FrameResult& result) {
    for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
    {
      const StageMeasurement measuring(&pipeline.meters(), StageId::kPublish);
      const auto latency_ms =
          options.realtime ? std::optional(handovers.LatencyMs(result.pose.t_capture)) : std::nullopt;
      if (publisher) publisher->Publish(result, latency_ms);
      writer.AddFrame(result, latency_ms);
      if (tracks) tracks->AddFrame(result);
    }
    summary.AddFrame(result);
    progress.Update(writer.num_frames(), Name(result.pose.status));
  };
  const auto next_frame = [&]() -> std::optional<SensorFrame> {
    if (Interrupted()) return std::nullopt;
    const StageMeasurement measuring(&pipeline.meters(), StageId::kLoad);
    return sequence->Next();
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
  if (publisher) publisher->Finish();
  if (Interrupted()) spdlog::warn("interrupted: the results hold what was read until then");

  RunTotals totals;
  totals.num_dropped = num_dropped + sequence->num_time_jumps();
  totals.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  totals.realtime = options.realtime;
  totals.gravity = pipeline.gravity();
  totals.stages = pipeline.meters().costs();
  writer.Finish(totals);
  if (tracks) tracks->Finish();
  summary.Print(writer, totals, options.output);
}

}  // namespace terrace
