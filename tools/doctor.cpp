// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>
#include <opencv2/core.hpp>
#include <unistd.h>

#include "core/print.h"
#include "daemon/interrupt.h"
#include "daemon/self_mask.h"
#include "datasets/calibration_file.h"
#include "datasets/euroc.h"
#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/sensor_codec.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/subscribe.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/health.h"
#include "tools/host_check.h"
#include "tools/input_watch.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Findings = std::vector<Finding>;

struct DoctorOptions {
  BusOptions bus;
  double seconds = 5.0;
};

/// Listens to everything that goes into a daemon and to what it says of itself.
class DoctorsEar {
 public:
  DoctorsEar(lcm::LCM* lcm, const Config& config) : lcm_(lcm), inputs_(config.live) {
    Subscribe<&DoctorsEar::OnImages>(lcm_, config.channels.images, this);
    Subscribe<&DoctorsEar::OnImu>(lcm_, config.channels.imu, this);
    Subscribe<&DoctorsEar::OnCalibration>(lcm_, config.channels.calibration, this);
    Subscribe<&DoctorsEar::OnStatus>(lcm_, config.channels.status, this);
  }

  void Listen(double seconds) {
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    while (Clock::now() < end && !Interrupted()) HandleFor(lcm_, 50);
  }

  const InputWatch& inputs() const { return inputs_; }
  const std::optional<StereoCalibration>& calibration() const { return calibration_; }

  /// Of the daemon, or of the daemons.
  Findings JudgeDaemons() const {
    if (!last_) {
      return {{Severity::kNote, "daemon", "no daemon is heard",
               "systemctl start terraced, or terraced --config FILE"}};
    }
    if (starts_ms_.size() > 1) {
      return {{Severity::kTrouble, "daemons",
               std::to_string(starts_ms_.size()) + " daemons share these channels",
               "end all but one, or give each a configuration with channels of its own"}};
    }
    Findings findings = JudgeStatus(*last_, first_->seq < last_->seq ? &*first_ : nullptr);
    if (findings.empty())
      findings.push_back({Severity::kGood, "daemon", "terraced " + last_->version + " is well", ""});
    return findings;
  }

 private:
  using Buffer = const lcm::ReceiveBuffer;

  static Timestamp Arrival(Buffer* buffer) { return Timestamp::FromMicroseconds(buffer->recv_utime); }

  void OnImages(Buffer* buffer, const std::string&) {
    const auto message = SafeDecode<images_t>(buffer->data, buffer->data_size);
    const auto t_capture = message ? CaptureTime(*message) : std::nullopt;
    if (!t_capture) return;
    inputs_.AddImageStamp(*t_capture, Arrival(buffer));
    // A look at one pair takes longer than a frame.
    constexpr std::chrono::milliseconds kBetweenPairs(700);
    if (Clock::now() < pair_due_) return;
    pair_due_ = Clock::now() + kBetweenPairs;
    inputs_.AddPair(FromMessage(*message));
  }

  void OnImu(Buffer* buffer, const std::string&) {
    const auto message = SafeDecode<imu_v1_t>(buffer->data, buffer->data_size);
    const auto sample = message ? FromMessage(*message) : std::nullopt;
    if (sample) inputs_.AddImu(*sample, Arrival(buffer));
  }

  void OnCalibration(Buffer* buffer, const std::string&) {
    const auto message = SafeDecode<calibration_v1_t>(buffer->data, buffer->data_size);
    if (message) calibration_ = FromMessage(*message);
  }

  void OnStatus(Buffer* buffer, const std::string&) {
    const auto message = SafeDecode<status_v1_t>(buffer->data, buffer->data_size);
    const auto status = message ? FromMessage(*message) : std::nullopt;
    if (!status) return;
    // Each daemon has begun at its own time.
    constexpr std::int64_t kSameStartMs = 500;
    const std::int64_t start_ms = status->t.ns / 1'000'000 - status->uptime_ms;
    const auto known = starts_ms_.lower_bound(start_ms - kSameStartMs);
    if (known == starts_ms_.end() || *known > start_ms + kSameStartMs) starts_ms_.insert(start_ms);
    if (!first_) first_ = status;
    last_ = status;
  }

  lcm::LCM* const lcm_;
  InputWatch inputs_;
  Clock::time_point pair_due_;
  std::optional<StereoCalibration> calibration_;
  std::optional<Status> first_;
  std::optional<Status> last_;
  std::set<std::int64_t> starts_ms_;
};

/// Sends itself messages as large as pairs of images over the bus.
class LoopbackTrial {
 public:
  explicit LoopbackTrial(const std::string& url) : sender_(url), receiver_(url) {
    RequireOpen(sender_, url);
    RequireOpen(receiver_, url);
    Subscribe<&LoopbackTrial::OnMessage>(&receiver_, kChannel, this);
  }

  Finding Run() {
    constexpr int kNumMessages = 15;
    const std::vector<std::uint8_t> pair(2 * 640 * 480, 128);
    for (int i = 0; i < kNumMessages; ++i) {
      sender_.publish(kChannel, pair.data(), static_cast<unsigned>(pair.size()));
      HandleFor(&receiver_, 33);
    }
    for (int i = 0; i < 10 && num_heard_ < kNumMessages; ++i) HandleFor(&receiver_, 20);
    const std::string text =
        Printed("%d of %d messages as large as pairs of 640x480 came through", num_heard_, kNumMessages);
    if (num_heard_ == kNumMessages) return {Severity::kGood, "loopback", text, ""};
    return {Severity::kTrouble, "loopback", text,
            num_heard_ == 0 ? "multicast does not work here: route and firewall, see above"
                            : "the receive buffer is too small, or the processor too busy"};
  }

 private:
  static constexpr const char* kChannel = "TERRACE_DOCTOR";
  void OnMessage(const lcm::ReceiveBuffer*, const std::string&) { ++num_heard_; }

  lcm::LCM sender_;
  lcm::LCM receiver_;
  int num_heard_ = 0;
};

/// Files that the configuration names, as the daemon will read them.
Findings CheckFiles(const Config& config, std::optional<StereoCalibration>* calibration) {
  Findings findings;
  try {
    const std::vector<fs::path> files = SplitFileList(config.live.calibration);
    if (files.size() == 1 && fs::is_directory(files[0] / "mav0"))
      *calibration = ReadEurocCalibration(files[0]);
    std::vector<std::string> notes;
    if (!files.empty() && !*calibration) *calibration = ReadRig(files, &notes);
    for (const std::string& note : notes) findings.push_back({Severity::kNote, "calibration", note, ""});
  } catch (const std::exception& error) {
    findings.push_back(
        {Severity::kTrouble, "calibration", error.what(), "terrace calibration FILE... says more"});
  }
  if (*calibration) {
    findings.push_back({Severity::kGood, "calibration",
                        config.live.calibration + ": " +
                            Printed("%dx%d, baseline %.4f m", (*calibration)->width, (*calibration)->height,
                                    (*calibration)->baseline_m()),
                        ""});
  }
  const std::string& folder = config.live.save_folder;
  if (!folder.empty()) {
    const bool writable = fs::is_directory(folder) && access(folder.c_str(), W_OK | X_OK) == 0;
    findings.push_back(
        {writable ? Severity::kGood : Severity::kTrouble, "save_folder",
         "lcm.save_folder = " + folder + (writable ? "" : ": cannot be written"),
         writable ? "" : "make it, owned by who runs the daemon; under systemd StateDirectory= does"});
  }
  return findings;
}

Findings CheckMask(const Config& config, const std::optional<StereoCalibration>& calibration) {
  if (!calibration) return {};
  try {
    const cv::Mat1b mask = LoadSelfMask(config.pipeline, *calibration);
    if (mask.empty()) return {};
    const double hidden =
        1.0 - static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
    constexpr double kMost = 0.6;
    return {{hidden < kMost ? Severity::kGood : Severity::kNote, "mask",
             Printed("the mask hides %.0f %% of the image", 100.0 * hidden),
             hidden < kMost ? "" : "0 is what is hidden: is it inverted?"}};
  } catch (const ConfigError& error) {
    return {{Severity::kTrouble, "mask", error.what(), ""}};
  }
}

void Say(const Findings& findings, Findings* all) {
  for (const Finding& finding : findings) std::fputs(InWords(finding).c_str(), stdout);
  std::fflush(stdout);
  all->insert(all->end(), findings.begin(), findings.end());
}

void Examine(const DoctorOptions& options) {
  const Config config = ConfigOf(options.bus);
  CatchInterrupts();
  Findings all;
  Say(JudgeHost(ReadHostFacts(config.live.url)), &all);
  std::optional<StereoCalibration> calibration;
  Say(CheckFiles(config, &calibration), &all);
  lcm::LCM lcm(config.live.url);
  RequireOpen(lcm, config.live.url);
  DoctorsEar ear(&lcm, config);
  ear.Listen(options.seconds);
  if (!calibration) calibration = ear.calibration();
  if (!calibration && config.live.calibration.empty()) {
    Say({{Severity::kTrouble, "calibration",
          "none is named, and none is heard on " + config.channels.calibration,
          "terrace calibration FILE... --output rig.yaml, then lcm.calibration: rig.yaml"}},
        &all);
  }
  Say(CheckMask(config, calibration), &all);
  Say(ear.inputs().JudgeStamps(), &all);
  Say(ear.inputs().JudgeImu(), &all);
  if (!calibration || calibration->Problems().empty())
    Say(ear.inputs().JudgePairs(calibration, config.pipeline.rectifier), &all);
  Say(ear.JudgeDaemons(), &all);
  Say({LoopbackTrial(config.live.url).Run()}, &all);
  std::size_t num_troubles = 0;
  for (const Finding& finding : all) num_troubles += finding.severity == Severity::kTrouble;
  if (num_troubles > 0) throw std::runtime_error(std::to_string(num_troubles) + " troubles, see above");
  std::printf("all is well\n");
}

}  // namespace

void AddDoctorCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "doctor",
      "Examine computer, files, inputs and daemon, and say how to mend what is wrong; exit code 0: nothing");
  auto options = std::make_shared<DoctorOptions>();
  AddBusOptions(command, &options->bus);
  command->add_option("--seconds", options->seconds, "how long to listen")
      ->check(CLI::Range(0.5, 600.0))
      ->capture_default_str();
  command->callback([options] { Examine(*options); });
}

}  // namespace terrace
