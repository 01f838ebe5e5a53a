// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/replay.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include <lcm/lcm-cpp.hpp>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/terrain_request_v1_t.hpp>

#include "client/terrace_file.h"
#include "daemon/interrupt.h"
#include "daemon/loaded_map_publisher.h"
#include "daemon/mapper_run.h"
#include "daemon/sinks.h"
#include "daemon/status_reporter.h"
#include "daemon/terrain_publisher.h"
#include "datasets/calibration_file.h"
#include "datasets/sequence.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"

namespace terrace {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// Frames of a recording; at their recorded times where that is wanted.
class SequenceSource {
 public:
  SequenceSource(Sequence* sequence, bool realtime, StageMeters* meters)
      : sequence_(sequence), realtime_(realtime), meters_(meters) {}

  /// None at the end, and after an interrupt.
  std::optional<SensorFrame> Next() {
    if (Interrupted()) return std::nullopt;
    std::optional<SensorFrame> frame = [this] {
      const StageMeasurement measuring(meters_, StageId::kLoad);
      return sequence_->Next();
    }();
    if (frame && realtime_ && !WaitUntil(start_ + (frame->pair.t_capture - sequence_->info().t_first)))
      return std::nullopt;
    return frame;
  }

 private:
  /// False when interrupted.
  static bool WaitUntil(SteadyClock::time_point due) {
    while (SteadyClock::now() < due) {
      if (Interrupted()) return false;
      std::this_thread::sleep_for(
          std::min<SteadyClock::duration>(due - SteadyClock::now(), std::chrono::milliseconds(50)));
    }
    return true;
  }

  Sequence* const sequence_;
  const bool realtime_;
  StageMeters* const meters_;
  const SteadyClock::time_point start_ = SteadyClock::now();
};

/// Publishes a replay as the live daemon would: every frame, a status once a second, where a loaded map lies,
/// and what subscribers lack.
class ReplayPublisher : public FrameSink {
 public:
  ReplayPublisher(const std::string& url, const Config& config, MapperRun* run)
      : run_(run),
        lcm_(url),
        publisher_(&lcm_, config.channels, run->pipeline().T_body_left(), config.live.snapshot_period_s),
        loaded_map_publisher_(&lcm_, config.channels, config.live.snapshot_period_s),
        desk_(&lcm_, config.channels),
        answers_(&desk_, &run->pipeline(), &publisher_),
        reporter_(&lcm_, config.channels.status, InputSource::kReplay, ConfigHash(config),
                  config.live.deadline_ms) {
    RequireOpen(lcm_, "--publish " + url);
    Subscribe<&ReplayPublisher::OnRepair>(&lcm_, config.channels.repair, this);
    Subscribe<&ReplayPublisher::OnRequest>(&lcm_, config.channels.request, this);
  }

  void AddPose(const PoseEstimate& pose) override {
    publisher_.PublishPose(pose);
    reporter_.AddFrameIn();
    reporter_.AddPose(pose);
  }

  void AddFrame(const FrameResult& result) override {
    publisher_.PublishTerrain(result.change);
    loaded_map_publisher_.Tick(run_->loaded_map(), publisher_.map_id());
    HandleAll();
    answers_.AddFrame(result);
    reporter_.AddResult(result);
    if (SteadyClock::now() < status_due_) return;
    status_due_ = SteadyClock::now() + std::chrono::seconds(1);
    Report(DaemonState::kRunning);
  }

  /// Stays until nobody has lacked anything for a while.
  void Finish(const RunTotals&) override {
    constexpr std::chrono::milliseconds kQuiet(250);
    constexpr std::chrono::seconds kPatience(5);
    publisher_.SendSnapshot();
    loaded_map_publisher_.SayWhereItLies(run_->loaded_map(), publisher_.map_id());
    const auto end = SteadyClock::now() + kPatience;
    t_repair_ = SteadyClock::now();
    while (!Interrupted() && SteadyClock::now() < end &&
           (publisher_.sending_snapshot() || SteadyClock::now() - t_repair_ < kQuiet)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      HandleAll();
      publisher_.Tick();
    }
    Report(DaemonState::kStopping);
  }

 private:
  void HandleAll() {
    while (lcm_.handleTimeout(0) > 0) {
    }
  }

  void OnRepair(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto repair = SafeDecode<terrain_repair_v1_t>(buffer->data, buffer->data_size);
    if (!repair) return;
    if (!loaded_map_publisher_.Answer(*repair)) publisher_.Answer(*repair);
    t_repair_ = SteadyClock::now();
  }

  void OnRequest(const lcm::ReceiveBuffer* buffer, const std::string&) {
    if (const auto request = SafeDecode<terrain_request_v1_t>(buffer->data, buffer->data_size))
      desk_.Take(*request, SteadyClock::now());
  }

  void Report(DaemonState state) {
    Status status = reporter_.Take(state, &run_->pipeline().meters());
    publisher_.Describe(&status);
    reporter_.Send(status);
  }

  MapperRun* const run_;
  lcm::LCM lcm_;
  TerrainPublisher publisher_;
  LoadedMapPublisher loaded_map_publisher_;
  RequestDesk desk_;
  RequestSink answers_;
  StatusReporter reporter_;
  SteadyClock::time_point status_due_;
  SteadyClock::time_point t_repair_;
};

/// Of the sequence, or of the files that replace it.
StereoCalibration CalibrationOf(const SequenceInfo& info, const ReplayOptions& options) {
  if (options.calibration.empty()) return info.calibration;
  RigOptions rig_options;
  rig_options.size = {info.calibration.width, info.calibration.height};
  std::vector<std::string> notes;
  StereoCalibration calibration = ReadRig(options.calibration, &notes, rig_options);
  for (const std::string& note : notes) spdlog::warn("{}", note);
  return calibration;
}

}  // namespace

void RunReplay(const ReplayOptions& options, const Config& config) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(options.num_threads));
  const std::unique_ptr<Sequence> sequence = OpenSequence(options.sequence, config.channels);
  const SequenceInfo& info = sequence->info();
  for (const std::string& warning : info.warnings) spdlog::warn("{}", warning);

  MapperRun run(config.pipeline, CalibrationOf(info, options),
                options.realtime ? Pace::kNewest : Pace::kEveryFrame,
                options.num_threads == 1 && !options.realtime);
  if (!config.live.load_map.empty())
    run.loaded_map().Load(LoadTerraceFile(config.live.load_map), config.live.load_map,
                          BodyInMapFrom(config.live.map_pose));
  if (!options.save_map.empty()) run.KeepViews();
  PrepareOutputFolder(options.output, options.overwrite);
  run.Add(std::make_unique<WarningLog>());
  if (!options.publish_url.empty())
    run.Add(std::make_unique<ReplayPublisher>(options.publish_url, config, &run));
  const ResultFiles* files =
      run.Add(std::make_unique<ResultFiles>(options.output, run.pipeline(), options.save_disparity_every));
  if (options.num_track_pictures > 0)
    run.Add(std::make_unique<TrackFiles>(options.output, options.num_track_pictures, info.num_frames));
  run.Add(std::make_unique<ReplayReport>(info, files, options.output));

  SequenceSource source(sequence.get(), options.realtime, &run.pipeline().meters());
  while (std::optional<SensorFrame> frame = source.Next())
    if (!run.Push(std::move(*frame))) break;
  if (Interrupted()) spdlog::warn("interrupted: the results hold what was read until then");
  run.Finish(sequence->num_time_jumps());
  if (options.save_map.empty()) return;
  const SavedMap saved = run.saved_map();
  if (!saved.map) throw OutputError(options.save_map.string() + ": no frames came, there is no map");
  SaveTerraceFile(options.save_map, *saved.map, saved.views);
}

}  // namespace terrace
