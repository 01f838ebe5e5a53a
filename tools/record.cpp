// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/pose_v1_t.hpp>

#include "core/file_bytes.h"
#include "core/print.h"
#include "daemon/interrupt.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/ring_log.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct RecordOptions {
  BusOptions bus;
  fs::path folder;
  double minutes = 5.0;
  double max_gb = 20.0;
  double after_s = 5.0;
  bool not_when_lost = false;
};

std::string TimeOfDay() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y%m%dT%H%M%SZ", &utc);
  return text;
}

/// A name that leads nowhere: letters, digits, - and _.
std::string Harmless(std::string name) {
  std::erase_if(name, [](unsigned char c) { return !std::isalnum(c) && c != '-' && c != '_'; });
  return name.substr(0, 64);
}

/// Everything that a robot's bus carries for and from a daemon, the last minutes of it, kept when something
/// has happened.
class Recorder {
 public:
  Recorder(lcm::LCM* lcm, const RecordOptions& options, const ChannelConfig& channels)
      : lcm_(lcm), options_(options), channels_(channels), ring_(options.folder / "ring", RingConfig()) {
    for (const std::string* channel : All()) {
      if (channel->empty()) continue;
      lcm::Subscription* subscription = Subscribe<&Recorder::OnMessage>(lcm_, *channel, this);
      // A disk that pauses for a second must not cost images or samples.
      constexpr int kImageCapacity = 60, kOtherCapacity = 2000;
      subscription->setQueueCapacity(channel == &channels_.images ? kImageCapacity : kOtherCapacity);
    }
  }

  ~Recorder() {
    if (joining_.joinable()) joining_.join();
  }

  void Run() {
    while (!Interrupted()) {
      HandleFor(lcm_, 50);
      if (keep_due_ && Clock::now() >= *keep_due_) Keep();
    }
    if (keep_due_) Keep();
  }

 private:
  RingLogConfig RingConfig() const {
    RingLogConfig config;
    config.span_s = 60.0 * options_.minutes;
    config.max_bytes = static_cast<std::int64_t>(1e9 * options_.max_gb);
    config.repeated_channels = {channels_.calibration};
    return config;
  }

  std::vector<const std::string*> All() const {
    return {&channels_.images,     &channels_.calibration, &channels_.imu,     &channels_.body_prior,
            &channels_.body_pose,  &channels_.command,     &channels_.reply,   &channels_.pose,
            &channels_.pose_state, &channels_.odometry,    &channels_.terrain, &channels_.repair,
            &channels_.status,     &channels_.true_pose,   &channels_.request, &channels_.height_map,
            &channels_.octree,     &channels_.disparity,   &channels_.map_box, &channels_.map_transform,
            &channels_.loaded_map, &channels_.footsteps};
  }

  void OnMessage(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    const auto* data = static_cast<const std::uint8_t*>(buffer->data);
    try {
      ring_.Add(buffer->recv_utime, channel, {data, buffer->data_size});
      if (std::exchange(cannot_write_, false)) spdlog::info("recording again");
    } catch (const FileError& error) {
      if (!std::exchange(cannot_write_, true))
        spdlog::error("not recording: {}; free space on the disk", error.what());
    }
    if (channel == channels_.pose_state && !options_.not_when_lost) WatchTracking(buffer);
    if (channel == channels_.command) WatchCommands(buffer);
  }

  void WatchTracking(const lcm::ReceiveBuffer* buffer) {
    const auto pose = SafeDecode<pose_v1_t>(buffer->data, buffer->data_size);
    if (!pose) return;
    const bool lost = pose->status == pose_v1_t::LOST;
    if (!std::exchange(lost_, lost) && lost) KeepSoon("lost");
  }

  void WatchCommands(const lcm::ReceiveBuffer* buffer) {
    const auto command = SafeDecode<command_v1_t>(buffer->data, buffer->data_size);
    if (!command || command->command != command_v1_t::KEEP_RECORD) return;
    const std::string name = Harmless(command->argument);
    const std::string path = KeepSoon(name.empty() ? "command" : name);
    command_reply_v1_t reply{};
    reply.utime = buffer->recv_utime;
    reply.request_id = command->request_id;
    reply.result = command_reply_v1_t::OK;
    reply.message = path;
    lcm_->publish(channels_.reply, &reply);
  }

  /// What follows is part of it. @return  where it will be
  std::string KeepSoon(const std::string& reason) {
    if (!keep_due_) {
      keep_due_ = Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * options_.after_s));
      keep_name_ = TimeOfDay() + "_" + reason;
      spdlog::info("{}: keeping the last {:.1f} s and the next {:.0f} s", reason, ring_.span_s(),
                   options_.after_s);
    }
    return KeptPath().string();
  }

  fs::path KeptPath() const { return options_.folder / (keep_name_ + ".lcmlog"); }

  void Keep() {
    keep_due_.reset();
    if (joining_.joinable()) joining_.join();
    try {
      const std::vector<fs::path> parts = ring_.Take(keep_name_);
      // Gigabytes take seconds to copy, in which the bus goes on.
      joining_ = std::thread([parts, path = KeptPath()] {
        try {
          JoinLogs(parts, path);
          spdlog::info("kept: {} ({:.0f} MB)", path.string(),
                       1e-6 * static_cast<double>(fs::file_size(path)));
        } catch (const std::exception& error) {
          spdlog::error("{}", error.what());
        }
      });
    } catch (const FileError& error) {
      spdlog::error("{}", error.what());
    }
  }

  lcm::LCM* const lcm_;
  const RecordOptions options_;
  const ChannelConfig channels_;
  RingLog ring_;
  bool lost_ = false;
  bool cannot_write_ = false;
  std::optional<Clock::time_point> keep_due_;
  std::string keep_name_;
  std::thread joining_;
};

void Record(const RecordOptions& options) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("terrace"));
  const Config config = ConfigOf(options.bus);
  CatchInterrupts();
  lcm::LCM lcm(config.live.url);
  RequireOpen(lcm, config.live.url);
  Recorder recorder(&lcm, options, config.channels);
  spdlog::info("recording the last {:.1f} min of {} into {}", options.minutes, config.live.url,
               options.folder.string());
  recorder.Run();
}

}  // namespace

void AddRecordCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "record",
      "Keep the last minutes of the bus on disk, as a log that replays, when tracking is lost or on command");
  auto options = std::make_shared<RecordOptions>();
  AddBusOptions(command, &options->bus);
  command->add_option("FOLDER", options->folder, "for the ring and for what is kept")->required();
  command->add_option("--minutes", options->minutes, "that are at hand")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->add_option("--max-gb", options->max_gb, "of the ring")
      ->check(CLI::Range(0.01, 10000.0))
      ->capture_default_str();
  command->add_option("--after", options->after_s, "seconds that are kept of what follows")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str();
  command->add_flag("--not-when-lost", options->not_when_lost,
                    "keep on command only (terrace command keep_record NAME)");
  command->callback([options] { Record(*options); });
}

}  // namespace terrace
