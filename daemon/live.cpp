// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live.h"

#include <cerrno>
#include <chrono>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <lcm/lcm-cpp.hpp>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <terrace/command_reply_v1_t.hpp>

#include "daemon/handover_times.h"
#include "daemon/interrupt.h"
#include "daemon/live_input.h"
#include "daemon/pipeline.h"
#include "daemon/result_writer.h"
#include "daemon/self_mask.h"
#include "daemon/status_reporter.h"
#include "daemon/terrain_publisher.h"
#include "daemon/threaded_pipeline.h"
#include "datasets/euroc.h"
#include "results/map_file.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

std::optional<StereoCalibration> CalibrationFrom(const std::string& folder) {
  if (folder.empty()) return std::nullopt;
  return ReadEurocCalibration(folder);
}

/// From the images being taken to now, when their clock is ours; else since they were handed over.
double AgeMs(Timestamp t_capture, double handover_ms) {
  constexpr double kMaxPlausibleMs = 10e3;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto age = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - t_capture.ns;
  const double age_ms = 1e-6 * static_cast<double>(age);
  return age_ms >= 0.0 && age_ms < kMaxPlausibleMs ? age_ms : handover_ms;
}

/// Everything that begins once the calibration is known.
class LiveMapper {
 public:
  LiveMapper(const LiveOptions& options, const Config& config, const StereoCalibration& calibration,
             lcm::LCM* lcm, StatusReporter* reporter)
      : reporter_(reporter),
        pipeline_(config.pipeline, calibration,
                  LoadSelfMask(config.pipeline.terrain.robot.self_mask_png,
                               RectifiedSize(calibration, config.pipeline.rectifier))),
        publisher_(lcm, config.channels, pipeline_.T_body_left(), config.live.snapshot_period_s),
        threads_(&pipeline_, WhenFull::kDropOldest,
                 [this](const SensorFrame&, const FrameResult& result) { TakeResult(result); }) {
    if (!options.output.empty())
      writer_.emplace(options.output,
                      ResultCamera{pipeline_.camera(), pipeline_.R_rect_raw(), pipeline_.T_body_left()}, 0);
  }

  /// False when a stage has failed.
  bool Push(SensorFrame frame) {
    reporter_->AddFrameIn();
    handovers_.Add(frame.pair.t_capture);
    return threads_.Push(std::move(frame));
  }

  /// Waits for what is under way and writes the results. Throws what a stage threw.
  void Finish(std::int64_t num_dropped_before) {
    threads_.Finish();
    if (!writer_ || !map()) return;
    RunTotals totals;
    totals.num_dropped = num_dropped_before + threads_.num_dropped();
    totals.wall_s = std::chrono::duration<double>(Clock::now() - start_).count();
    totals.realtime = true;
    totals.gravity = pipeline_.gravity();
    totals.stages = pipeline_.meters().costs();
    writer_->Finish(totals);
  }

  TerrainMapPtr map() const {
    const std::lock_guard lock(mutex_);
    return map_;
  }
  Pipeline& pipeline() { return pipeline_; }
  TerrainPublisher& publisher() { return publisher_; }
  std::int64_t num_dropped() const { return threads_.num_dropped(); }
  /// What is known of the map, and of what waits or was dropped on the way to it.
  void Describe(Status* status) const {
    publisher_.Describe(status);
    for (StageStatus& stage : status->stages) {
      if (stage.name != "rectify") continue;
      stage.num_dropped = threads_.num_dropped();
      stage.queue_depth = static_cast<int>(threads_.queue_depth());
    }
  }

 private:
  void TakeResult(const FrameResult& result) {
    for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
    const StageMeasurement measuring(&pipeline_.meters(), StageId::kPublish);
    publisher_.Publish(result.pose, result.change.map);
    const double latency_ms = handovers_.LatencyMs(result.pose.t_capture);
    reporter_->AddResult(result, AgeMs(result.pose.t_capture, latency_ms));
    if (writer_) writer_->AddFrame(result, latency_ms);
    const std::lock_guard lock(mutex_);
    map_ = result.change.map;
  }

  StatusReporter* const reporter_;
  const Clock::time_point start_ = Clock::now();
  HandoverTimes handovers_;
  Pipeline pipeline_;
  TerrainPublisher publisher_;
  std::optional<ResultWriter> writer_;
  mutable std::mutex mutex_;
  TerrainMapPtr map_;
  ThreadedPipeline threads_;  // last: its threads use everything above
};

struct Reply {
  std::int8_t result = command_reply_v1_t::OK;
  std::string message;
};

class LiveNode {
 public:
  LiveNode(const LiveOptions& options, const Config& config)
      : options_(options),
        config_(config),
        lcm_(config.live.url),
        reporter_(&lcm_, config.channels.status, InputSource::kLive, ConfigHash(config),
                  config.live.deadline_ms) {
    if (!lcm_.good()) throw std::runtime_error("lcm.url = " + config.live.url + ": cannot be opened");
    if (!options.output.empty()) PrepareOutputFolder(options.output, options.overwrite);
    input_.emplace(
        &lcm_, config.channels, config.live, CalibrationFrom(config.live.calibration_folder),
        [this](const command_v1_t& command) { Answer(command); },
        [this](const terrain_repair_v1_t& repair) {
          if (mapper_) mapper_->publisher().Answer(repair);
        });
    spdlog::info("live on {}", config.live.url);
  }

  void Run() {
    constexpr int kPatienceMs = 20;
    while (!Interrupted()) {
      // A signal makes the waiting fail, too.
      if (lcm_.handleTimeout(kPatienceMs) < 0 && errno != EINTR)
        throw std::runtime_error(config_.live.url + ": LCM has failed");
      if (!mapper_ && input_->calibration()) StartMapper();
      while (std::optional<SensorFrame> frame = input_->NextReady()) {
        if (!Push(std::move(*frame))) break;
      }
      if (mapper_) mapper_->publisher().Tick();
      ReportEverySecond();
    }
    Finish();
  }

 private:
  void StartMapper() {
    mapper_ = std::make_unique<LiveMapper>(options_, config_, *input_->calibration(), &lcm_, &reporter_);
    spdlog::info("calibration: {}", input_->calibration()->name);
  }

  bool Push(SensorFrame frame) {
    if (paused_) return true;
    if (mapper_->Push(std::move(frame))) return true;
    mapper_->Finish(0);  // throws what has ended it
    throw std::runtime_error("the pipeline has ended");
  }

  void Finish() {
    if (mapper_) {
      while (std::optional<SensorFrame> frame = input_->NextAny()) {
        if (!Push(std::move(*frame))) break;
      }
      mapper_->Finish(input_->num_time_jumps());
    }
    Report(DaemonState::kStopping);
    if (options_.output.empty()) return;
    if (mapper_ && mapper_->map()) {
      spdlog::info("results: {}", options_.output.string());
    } else {
      spdlog::warn("no frames came: no results");
    }
  }

  DaemonState State() {
    constexpr std::chrono::seconds kSilent(1);
    if (!input_->calibration()) return DaemonState::kNoCalibration;
    if (paused_) return DaemonState::kPaused;
    if (input_->silence() > kSilent) return DaemonState::kNoInput;
    return mapper_->map() ? DaemonState::kRunning : DaemonState::kStarting;
  }

  void ReportEverySecond() {
    const auto now = Clock::now();
    if (now < report_due_) return;
    report_due_ = now + std::chrono::seconds(1);
    Report(State());
  }

  void Report(DaemonState state) {
    Status status = reporter_.Take(state, mapper_ ? &mapper_->pipeline().meters() : nullptr);
    if (mapper_) mapper_->Describe(&status);
    status.inputs = input_->TakeInputs();
    status.num_bad_frames = input_->num_bad_frames();
    status.num_decode_errors = input_->num_decode_errors();
    status.num_time_jumps = input_->num_time_jumps();
    status.num_imu_gaps = input_->num_imu_gaps();
    const std::int64_t num_troubles = status.num_bad_frames + status.num_decode_errors +
                                      status.num_time_jumps + status.num_imu_gaps +
                                      (mapper_ ? mapper_->num_dropped() : 0);
    if (status.state == DaemonState::kRunning && num_troubles > num_troubles_) {
      status.state = DaemonState::kDegraded;
      if (status.reason.empty()) {
        status.reason = "input was lost, late, damaged or dropped; see the counters";
        status.reason_code = ReasonCode::kInputTrouble;
      }
    }
    num_troubles_ = num_troubles;
    if (status.state == DaemonState::kNoCalibration) {
      status.reason = SayThatCalibrationIsMissing();
      status.reason_code =
          input_->calibration_problem().empty() ? ReasonCode::kNoCalibration : ReasonCode::kBadCalibration;
    }
    if (status.state == DaemonState::kNoInput) {
      status.reason = "no images on " + config_.channels.images;
      status.reason_code = ReasonCode::kNoImages;
    }
    reporter_.Send(status);
  }

  std::string SayThatCalibrationIsMissing() {
    const std::string text = input_->calibration_problem().empty()
                                 ? "no calibration yet: waiting for calibration_v1_t on " +
                                       config_.channels.calibration + " (or set lcm.calibration_folder)"
                                 : input_->calibration_problem();
    if (!std::exchange(calibration_missing_said_, true)) spdlog::warn("{}", text);
    return text;
  }

  void Answer(const command_v1_t& command) {
    Reply reply = Obey(command);
    command_reply_v1_t message{};
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    message.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
    message.request_id = command.request_id;
    message.result = reply.result;
    message.message = std::move(reply.message);
    lcm_.publish(config_.channels.reply, &message);
  }

  Reply Obey(const command_v1_t& command) {
    switch (command.command) {
      case command_v1_t::RESET_MAP:
        if (mapper_) mapper_->pipeline().RequestMapReset();
        spdlog::info("the map begins anew, as commanded");
        return {command_reply_v1_t::OK, "the map begins anew with the next frame"};
      case command_v1_t::PAUSE:
        paused_ = true;
        spdlog::info("paused, as commanded");
        return {command_reply_v1_t::OK, "paused: frames are left out until RESUME"};
      case command_v1_t::RESUME:
        paused_ = false;
        spdlog::info("resumed, as commanded");
        return {command_reply_v1_t::OK, "resumed"};
      case command_v1_t::SAVE_MAP:
        return SaveMap(command.argument);
      case command_v1_t::SEND_SNAPSHOT:
        if (mapper_ && mapper_->publisher().SendSnapshot()) return {command_reply_v1_t::OK, "sent"};
        return {command_reply_v1_t::REFUSED, "there is no map yet"};
      case command_v1_t::RELOAD_CONFIG:
        return {command_reply_v1_t::REFUSED, "settings are read at the start: restart the daemon"};
      default:
        return {command_reply_v1_t::REFUSED, "no such command: " + std::to_string(command.command)};
    }
  }

  /// The name may not lead out of the folder: anyone on the bus can send it.
  Reply SaveMap(const std::string& name) {
    const std::filesystem::path folder =
        config_.live.save_folder.empty() ? options_.output : std::filesystem::path(config_.live.save_folder);
    if (folder.empty())
      return {command_reply_v1_t::REFUSED, "set lcm.save_folder, the folder to save maps into"};
    if (name.empty() || name.find('/') != std::string::npos || name == "." || name == "..") {
      return {command_reply_v1_t::REFUSED,
              "argument '" + name + "' must be the name of a file, without a folder"};
    }
    const TerrainMapPtr map = mapper_ ? mapper_->map() : nullptr;
    if (!map) return {command_reply_v1_t::REFUSED, "there is no map yet"};
    const std::filesystem::path file = folder / name;
    std::ofstream out(file, std::ios::binary);
    out << TerrainMapJson(*map);
    out.close();
    if (!out) return {command_reply_v1_t::FAILED, file.string() + ": cannot be written"};
    return {command_reply_v1_t::OK, file.string()};
  }

  const LiveOptions options_;
  const Config config_;
  lcm::LCM lcm_;
  StatusReporter reporter_;
  std::optional<LiveInput> input_;
  std::unique_ptr<LiveMapper> mapper_;
  bool paused_ = false;
  bool calibration_missing_said_ = false;
  Clock::time_point report_due_ = Clock::now() + std::chrono::seconds(1);
  std::int64_t num_troubles_ = 0;
};

}  // namespace

void RunLive(const LiveOptions& options, const Config& config) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(options.num_threads));
  LiveNode(options, config).Run();
}

}  // namespace terrace
