// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "core/file_bytes.h"
#include "daemon/interrupt.h"
#include "datasets/calibration_file.h"
#include "datasets/lcm_log_writer.h"
#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/open_bus.h"
#include "tools/bus.h"
#include "tools/camera_config.h"
#include "tools/camera_pairs.h"
#include "tools/commands.h"
#include "tools/frame_file.h"
#include "tools/v4l2_camera.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct CameraOptions {
  BusOptions bus;
  fs::path camera;
  std::string calibration;
  fs::path record;
  fs::path save_frames;
  fs::path play_frames;
};

/// Sends pairs and calibration, and writes them where that is asked for.
class PairPublisher {
 public:
  PairPublisher(const CameraOptions& options, const Config& config, ImageEncoding encoding)
      : lcm_(config.live.url), channels_(config.channels), encoding_(encoding) {
    RequireOpen(lcm_, config.live.url);
    const std::string files = options.calibration.empty() ? config.live.calibration : options.calibration;
    if (!files.empty()) {
      std::vector<std::string> notes;
      calibration_ = ReadRig(SplitFileList(files), &notes);
      for (const std::string& note : notes) spdlog::warn("{}", note);
    }
    if (options.record.empty()) return;
    if (!calibration_) throw UsageError("--record needs --calibration: a log without one cannot be replayed");
    if (fs::exists(options.record)) throw UsageError(options.record.string() + ": exists");
    log_.emplace(options.record, *calibration_, std::vector<TimedPose>{}, encoding, channels_);
  }

  void Send(StereoPair pair) {
    if (calibration_ && pair.problem.empty() &&
        (pair.left.width != calibration_->width || pair.left.height != calibration_->height)) {
      throw std::runtime_error("each image is " + std::to_string(pair.left.width) + "x" +
                               std::to_string(pair.left.height) + ", the calibration is for " +
                               std::to_string(calibration_->width) + "x" +
                               std::to_string(calibration_->height));
    }
    const images_t images = ToMessage(pair, encoding_);
    lcm_.publish(channels_.images, &images);
    SendCalibration(pair.t_capture);
    ++num_pairs_;
    num_bad_ += !pair.problem.empty();
    if (!log_) return;
    SensorFrame frame;
    frame.pair = std::move(pair);
    log_->Add(frame);
  }

  void Finish() {
    if (log_) log_->Finish();
  }
  std::int64_t num_pairs() const { return num_pairs_; }
  std::int64_t num_bad() const { return num_bad_; }

 private:
  void SendCalibration(Timestamp t) {
    if (!calibration_ || Clock::now() < calibration_due_) return;
    calibration_due_ = Clock::now() + std::chrono::seconds(1);
    const calibration_v1_t message = ToMessage(*calibration_, t);
    lcm_.publish(channels_.calibration, &message);
  }

  lcm::LCM lcm_;
  const ChannelConfig channels_;
  const ImageEncoding encoding_;
  std::optional<StereoCalibration> calibration_;
  std::optional<LcmLogWriter> log_;
  Clock::time_point calibration_due_;
  std::int64_t num_pairs_ = 0;
  std::int64_t num_bad_ = 0;
};

using Sources = std::vector<std::unique_ptr<FrameSource>>;

Sources OpenSources(const CameraOptions& options, const CameraConfig& camera) {
  Sources sources;
  if (!options.play_frames.empty()) {
    const auto start = Clock::now();
    for (int device = 0; device < (camera.has_two_devices() ? 2 : 1); ++device)
      sources.push_back(std::make_unique<RecordedFrames>(options.play_frames, device, start));
    return sources;
  }
  for (const std::string& device : {camera.device, camera.device_right}) {
    if (device.empty()) continue;
    auto source = std::make_unique<V4l2Camera>(device, camera);
    for (const std::string& note : source->notes()) spdlog::warn("{}", note);
    sources.push_back(std::move(source));
  }
  return sources;
}

/// A camera at work: opens it, sends what it sends, and opens it again when it was gone.
class CameraDriver {
 public:
  CameraDriver(const CameraOptions& options, const CameraConfig& camera, PairPublisher* publisher)
      : options_(options), camera_(camera), publisher_(publisher), pairs_(camera) {
    if (!options.save_frames.empty()) saved_.emplace(options.save_frames);
  }

  void Run() {
    while (!Interrupted()) {
      try {
        Sources sources = OpenSources(options_, camera_);
        if (options_.play_frames.empty())
          spdlog::info("{}: open, {} {}x{}", camera_.device, camera_.format, camera_.width, camera_.height);
        else
          spdlog::info("{}: played instead of {}", options_.play_frames.string(), camera_.device);
        gone_ = false;
        if (!RunUntilGone(&sources)) break;
      } catch (const CameraGone& error) {
        if (!std::exchange(gone_, true)) spdlog::error("{}; waiting for it", error.what());
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
      }
    }
    if (saved_) saved_->Close();
    spdlog::info("{} pairs, {} of them unreadable; {} frames without a partner, {} lost by the driver",
                 publisher_->num_pairs(), publisher_->num_bad(), pairs_.num_unmatched(), pairs_.num_lost());
  }

 private:
  /// @return  false: there will be no more
  bool RunUntilGone(Sources* sources) {
    constexpr std::chrono::seconds kSilent(2);
    constexpr int kPatienceMs = 20;
    auto last = Clock::now();
    while (!Interrupted()) {
      bool all_ended = true;
      for (std::size_t device = 0; device < sources->size(); ++device) {
        all_ended = (*sources)[device]->ended() && all_ended;
        std::optional<RawFrame> frame =
            (*sources)[device]->Next(sources->size() == 1 ? kPatienceMs : kPatienceMs / 4);
        if (!frame) continue;
        last = Clock::now();
        if (saved_) saved_->Add(static_cast<int>(device), *frame);
        if (auto pair = pairs_.Add(static_cast<int>(device), std::move(*frame)))
          publisher_->Send(std::move(*pair));
      }
      if (all_ended) return false;
      if (Clock::now() - last > kSilent) throw CameraGone(camera_.device + ": no image for 2 s");
    }
    return false;
  }

  const CameraOptions options_;
  const CameraConfig camera_;
  PairPublisher* const publisher_;
  PairMaker pairs_;
  std::optional<FrameFileWriter> saved_;
  bool gone_ = false;
};

void RunCamera(const CameraOptions& options) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("terrace"));
  const Config config = ConfigOf(options.bus);
  std::optional<CameraConfig> camera;
  try {
    camera = ReadCameraConfig(options.camera);
  } catch (const FileError& error) {
    throw UsageError(error.what());
  }
  CatchInterrupts();
  PairPublisher publisher(options, config, *ImageEncodingFromName(camera->encoding));
  CameraDriver(options, *camera, &publisher).Run();
  publisher.Finish();
}

}  // namespace

void AddCameraCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("camera", "Drive a stereo camera (V4L2) and send its pairs to the daemon");
  auto options = std::make_shared<CameraOptions>();
  AddBusOptions(command, &options->bus);
  command->add_option("CAMERA", options->camera, "a YAML file as those in share/terrace/cameras")->required();
  command->add_option(
      "--calibration", options->calibration,
      "files of any tool that terrace calibration reads, commas between; else lcm.calibration");
  command->add_option("--record", options->record, "an LCM log that replays, beside sending");
  command->add_option("--save-frames", options->save_frames,
                      "what the devices send, byte by byte, for --play-frames");
  command->add_option("--play-frames", options->play_frames, "instead of devices: what --save-frames saved");
  command->callback([options] { RunCamera(*options); });
}

}  // namespace terrace
