// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live.h"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <lcm/lcm-cpp.hpp>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <terrace/status_v1_t.hpp>

#include "client/terrace_file.h"
#include "core/print.h"
#include "core/time.h"
#include "daemon/commands.h"
#include "daemon/input_troubles.h"
#include "daemon/interrupt.h"
#include "daemon/live_input.h"
#include "daemon/loaded_map_publisher.h"
#include "daemon/mapper_run.h"
#include "daemon/request_desk.h"
#include "daemon/service_notice.h"
#include "daemon/sinks.h"
#include "daemon/state_log.h"
#include "daemon/status_reporter.h"
#include "daemon/terrain_publisher.h"
#include "daemon/thread_priority.h"
#include "datasets/calibration_file.h"
#include "datasets/euroc.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

/// As configured; none: it comes as a message.
std::optional<StereoCalibration> CalibrationFrom(const std::string& configured) {
  const std::vector<std::filesystem::path> files = SplitFileList(configured);
  if (files.empty()) return std::nullopt;
  // The folder of a recording knows its IMU, too.
  if (files.size() == 1 && std::filesystem::is_directory(files[0] / "mav0"))
    return ReadEurocCalibration(files[0]);
  std::vector<std::string> notes;
  StereoCalibration calibration = ReadRig(files, &notes);
  for (const std::string& note : notes) spdlog::warn("{}", note);
  return calibration;
}

/// Everything that begins once the calibration is known.
struct LiveMapper {
  LiveMapper(const LiveOptions& options, const Config& config, const StereoCalibration& calibration,
             lcm::LCM* lcm, StatusReporter* reporter, RequestDesk* desk)
      : run(config.pipeline, calibration, Pace::kNewest, false),
        publisher(lcm, config.channels, run.pipeline().T_body_left(), config.live.snapshot_period_s),
        loaded_map_publisher(lcm, config.channels, config.live.snapshot_period_s) {
    run.KeepViews();
    run.Add(std::make_unique<WarningLog>());
    run.Add(std::make_unique<PublisherSink>(&publisher));
    run.Add(std::make_unique<RequestSink>(desk, &run.pipeline(), &publisher));
    run.Add(std::make_unique<StatusSink>(reporter));
    if (!options.output.empty()) run.Add(std::make_unique<ResultFiles>(options.output, run.pipeline(), 0));
  }

  MapperRun run;
  TerrainPublisher publisher;
  LoadedMapPublisher loaded_map_publisher;
};

class LiveNode {
 public:
  LiveNode(const LiveOptions& options, const Config& config)
      : options_(options),
        config_(config),
        lcm_(config.live.url),
        reporter_(&lcm_, config.channels.status, InputSource::kLive, ConfigHash(config),
                  config.live.deadline_ms),
        obeyer_(
            config.live.save_folder.empty() ? options.output : std::filesystem::path(config.live.save_folder),
            Actions()),
        desk_(&lcm_, config.channels) {
    RequireOpen(lcm_, "lcm.url = " + config.live.url);
    if (!config.live.load_map.empty()) first_map_ = LoadTerraceFile(config.live.load_map);
    if (!options.output.empty()) PrepareOutputFolder(options.output, options.overwrite);
    input_.emplace(
        &lcm_, config.channels, config.live, CalibrationFrom(config.live.calibration),
        [this](const command_v1_t& command) { Answer(command); },
        [this](const terrain_repair_v1_t& repair) {
          if (!mapper_ || mapper_->loaded_map_publisher.Answer(repair)) return;
          mapper_->publisher.Answer(repair);
        },
        [this](const terrain_request_v1_t& request) { desk_.Take(request, Clock::now()); });
    Subscribe<&LiveNode::OnStatus>(&lcm_, config.channels.status, this);
    spdlog::info("live on {}", config.live.url);
  }

  void Run() {
    constexpr int kPatienceMs = 20;
    while (!Interrupted()) {
      // A signal makes the waiting fail, too.
      if (lcm_.handleTimeout(kPatienceMs) < 0 && errno != EINTR)
        throw std::runtime_error(config_.live.url + ": LCM has failed");
      if (!mapper_ && input_->calibration()) StartMapper();
      while (std::optional<SensorFrame> frame = input_->NextReady()) Push(std::move(*frame));
      if (mapper_) {
        mapper_->publisher.Tick();
        mapper_->loaded_map_publisher.Tick(mapper_->run.loaded_map(), mapper_->publisher.map_id());
      }
      ReportEverySecond();
    }
    Finish();
  }

 private:
  /// Two daemons on one bus publish poses and maps over each other.
  void OnStatus(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    const auto status = SafeDecode<status_v1_t>(buffer->data, buffer->data_size);
    if (!status || reporter_.HasSent(Timestamp::FromMicroseconds(status->utime))) return;
    other_heard_ = Clock::now();
    if (!std::exchange(other_said_, true))
      spdlog::warn("another terraced speaks on {}: stop one of them, or give it other channels", channel);
  }

  /// A calibration that came as a message and does not fit the configuration is no reason to end.
  void StartMapper() {
    try {
      mapper_ =
          std::make_unique<LiveMapper>(options_, config_, *input_->calibration(), &lcm_, &reporter_, &desk_);
    } catch (const ConfigError& error) {
      if (!config_.live.calibration.empty()) throw;
      input_->RefuseCalibration(input_->calibration()->name + ": " + error.what());
      return;
    }
    mapper_->run.pipeline().PauseMap(paused_);
    if (first_map_)
      mapper_->run.loaded_map().Load(std::exchange(first_map_, std::nullopt).value(), config_.live.load_map,
                                     BodyInMapFrom(config_.live.map_pose));
    spdlog::info("calibration: {}", input_->calibration()->name);
  }

  void Push(SensorFrame frame) {
    reporter_.AddFrameIn();
    if (mapper_->run.Push(std::move(frame))) return;
    mapper_->run.Finish(0);  // throws what has ended it
    throw std::runtime_error("the pipeline has ended");
  }

  void Finish() {
    if (mapper_) {
      while (std::optional<SensorFrame> frame = input_->NextAny()) Push(std::move(*frame));
      mapper_->run.Finish(input_->num_time_jumps());
    }
    Report(DaemonState::kStopping);
    if (options_.output.empty()) return;
    if (mapper_ && mapper_->run.map()) {
      spdlog::info("results: {}", options_.output.string());
    } else {
      spdlog::warn("no frames came: the results are empty");
    }
  }

  DaemonState State() {
    constexpr std::chrono::seconds kSilent(1);
    if (!input_->calibration()) return DaemonState::kNoCalibration;
    if (input_->silence() > kSilent) return DaemonState::kNoInput;
    if (paused_) return DaemonState::kPaused;
    return mapper_->run.map() ? DaemonState::kRunning : DaemonState::kStarting;
  }

  void ReportEverySecond() {
    const auto now = Clock::now();
    if (now < report_due_) return;
    report_due_ = now + std::chrono::seconds(1);
    Report(State());
  }

  void Report(DaemonState state) {
    Status status = reporter_.Take(state, mapper_ ? &mapper_->run.pipeline().meters() : nullptr);
    if (mapper_) mapper_->publisher.Describe(&status);
    status.inputs = input_->TakeInputs();
    status.num_bad_frames = input_->num_bad_frames();
    status.num_decode_errors = input_->num_decode_errors();
    status.num_time_jumps = input_->num_time_jumps();
    status.num_imu_gaps = input_->num_imu_gaps();
    const FlowCounts counts = mapper_ ? mapper_->run.counts() : FlowCounts{};
    SetFlow(counts, &status);
    AddLastingTroubles(&status);
    // A map that leaves frames out is a slower map, not a damaged one.
    AddTrouble(input_troubles_.Take(status, counts.num_dropped), ReasonCode::kInputTrouble, &status);
    if (status.state == DaemonState::kNoCalibration) {
      status.reason = SayThatCalibrationIsMissing();
      status.reason_code =
          input_->calibration_problem().empty() ? ReasonCode::kNoCalibration : ReasonCode::kBadCalibration;
    }
    if (status.state == DaemonState::kNoInput) {
      const std::string why = WhyImagesAreNotTaken();
      status.reason = why.empty() ? "no images on " + config_.channels.images : why;
      status.reason_code = ReasonCode::kNoImages;
    }
    reporter_.Send(status);
    service_.Tell(status);
    LogChange(status);
  }

  /// A reason of before is the more urgent one.
  static void AddTrouble(const std::string& text, ReasonCode code, Status* status) {
    if (text.empty()) return;
    if (status->state == DaemonState::kRunning) status->state = DaemonState::kDegraded;
    if (!status->reason.empty()) return;
    status->reason = text;
    status->reason_code = code;
  }

  std::string WhyImagesAreNotTaken() const {
    const std::string& why = input_->why_no_images();
    return why.empty() ? why : "images on " + config_.channels.images + " are not taken: " + why;
  }

  void AddLastingTroubles(Status* status) {
    AddTrouble(WhyImagesAreNotTaken(), ReasonCode::kNoImages, status);
    if (const auto ahead = input_->imu_clock_ahead())
      AddTrouble(
          Printed("the IMU's time stamps are %.1f s %s those of the images: of another clock, and of no use",
                  std::abs(Seconds(*ahead)), ahead->count() > 0 ? "ahead of" : "behind"),
          ReasonCode::kOther, status);
    if (input_->calibration_has_changed())
      AddTrouble("the calibration on " + config_.channels.calibration +
                     " has changed: the one of before is used until terraced is started again",
                 ReasonCode::kOther, status);
    constexpr std::chrono::seconds kRecently(3);
    if (other_heard_ && Clock::now() - *other_heard_ < kRecently)
      AddTrouble("another terraced speaks on this bus", ReasonCode::kInputTrouble, status);
  }

  void LogChange(const Status& status) {
    // That there is no calibration has been said, in more words.
    if (status.state == DaemonState::kNoCalibration) return;
    const std::optional<StateLog::Line> line = state_log_.Add(status);
    if (line) spdlog::log(line->is_trouble ? spdlog::level::warn : spdlog::level::info, "{}", line->text);
  }

  static void SetFlow(const FlowCounts& counts, Status* status) {
    for (StageStatus& stage : status->stages) {
      if (stage.name == Name(StageId::kOdometry)) {
        stage.num_dropped = counts.num_dropped;
        stage.queue_depth = counts.num_waiting;
      }
      if (stage.name == Name(StageId::kDecomposition)) {
        stage.num_dropped = counts.num_passed_over;
        stage.queue_depth = counts.num_waiting_for_map;
      }
    }
  }

  /// What is wrong with one that came has been said when it came.
  std::string SayThatCalibrationIsMissing() {
    const std::string problem = input_->calibration_problem();
    if (!problem.empty()) return problem;
    const std::string text = "no calibration yet: waiting for calibration_v1_t on " +
                             config_.channels.calibration + " (or set lcm.calibration)";
    if (!std::exchange(calibration_missing_said_, true)) spdlog::warn("{}", text);
    return text;
  }

  CommandActions Actions() {
    return {[this] {
              if (mapper_) mapper_->run.pipeline().RequestMapReset();
            },
            [this](bool paused) {
              paused_ = paused;
              if (mapper_) mapper_->run.pipeline().PauseMap(paused);
            },
            [this] { return mapper_ && mapper_->publisher.SendSnapshot(); },
            [this] { return mapper_ ? mapper_->run.saved_map() : SavedMap{}; },
            [this](std::int64_t id) { return mapper_ ? mapper_->run.Explain(id) : Explanations{}; },
            [this](SavedMap saved, const std::string& file, const std::optional<BodyInMap>& body) {
              if (mapper_) mapper_->run.loaded_map().Load(std::move(saved), file, body);
              return mapper_ != nullptr;
            }};
  }

  void Answer(const command_v1_t& command) {
    if (command.command == command_v1_t::KEEP_RECORD) return;  // the recorder answers
    command_reply_v1_t reply = obeyer_.Obey(command);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    reply.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
    reply.request_id = command.request_id;
    lcm_.publish(config_.channels.reply, &reply);
  }

  const LiveOptions options_;
  const Config config_;
  lcm::LCM lcm_;
  StatusReporter reporter_;
  CommandObeyer obeyer_;
  RequestDesk desk_;
  ServiceNotice service_;
  StateLog state_log_;
  std::optional<LiveInput> input_;
  std::unique_ptr<LiveMapper> mapper_;
  std::optional<SavedMap> first_map_;  // to begin with, until there is a mapper
  bool paused_ = false;
  bool calibration_missing_said_ = false;
  std::optional<Clock::time_point> other_heard_;
  bool other_said_ = false;
  Clock::time_point report_due_ = Clock::now() + std::chrono::seconds(1);
  InputTroubles input_troubles_;
};

}  // namespace

void RunLive(const LiveOptions& options, const Config& config) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(options.num_threads));
  const WorkersYieldToThePose workers;
  LiveNode(options, config).Run();
}

}  // namespace terrace
