// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/file_bytes.h"
#include "datasets/calibration_file.h"
#include "datasets/ground_truth.h"
#include "datasets/lcm_log_writer.h"
#include "datasets/sequence.h"
#include "tools/commands.h"
#include "tools/side_by_side.h"

namespace terrace {
namespace {

struct ConvertOptions {
  std::filesystem::path sequence;
  std::filesystem::path log;
  std::string images = "raw";
  bool overwrite = false;
  bool side_by_side = false;
  std::string calibration;
  std::optional<double> rate_hz;
};

/// Gone when nobody renamed it.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(std::filesystem::path path) : path_(std::move(path)) {}
  ~UnfinishedFile() {
    std::error_code error;
    std::filesystem::remove(path_, error);
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  const std::filesystem::path path_;
};

std::vector<TimedPose> TruePosesOf(const SequenceInfo& info) {
  if (!info.has_true_poses) return {};
  return TruePosesForLog(LoadTrueTrajectory(info.path), info.calibration);
}

/// What a log was made of, and what of it could not be used.
struct ConvertCounts {
  std::int64_t num_frames = 0, num_bad = 0, num_imu = 0, num_priors = 0;

  void Add(const SensorFrame& frame) {
    ++num_frames;
    num_bad += frame.pair.problem.empty() ? 0 : 1;
    num_imu += static_cast<std::int64_t>(frame.samples.imu.size());
    num_priors += static_cast<std::int64_t>(frame.samples.priors.size());
  }
  void Print(const std::filesystem::path& log) const {
    std::printf("%s: %lld stereo pairs (%lld unreadable), %lld IMU samples, %lld priors, %.1f MB\n",
                log.c_str(), static_cast<long long>(num_frames), static_cast<long long>(num_bad),
                static_cast<long long>(num_imu), static_cast<long long>(num_priors),
                static_cast<double>(std::filesystem::file_size(log)) * 1e-6);
  }
};

/// Images or a video that hold both cameras side by side.
void ConvertSideBySide(const ConvertOptions& options) {
  if (options.calibration.empty())
    throw UsageError("--side-by-side needs --calibration: images do not carry one");
  std::vector<std::string> notes;
  const StereoCalibration rig = ReadRig(SplitFileList(options.calibration), &notes);
  for (const std::string& note : notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  const NextPair next_pair = OpenSideBySide(options.sequence, options.rate_hz);
  const UnfinishedFile unfinished(options.log.string() + ".unfinished");
  LcmLogWriter writer(unfinished.path(), rig, {}, *ImageEncodingFromName(options.images));
  ConvertCounts counts;
  while (std::optional<StereoPair> pair = next_pair()) {
    SensorFrame frame;
    frame.pair = std::move(*pair);
    if (frame.pair.problem.empty() &&
        (frame.pair.left.width != rig.width || frame.pair.left.height != rig.height)) {
      throw SequenceError(options.sequence.string() + ": each half is " +
                          std::to_string(frame.pair.left.width) + "x" +
                          std::to_string(frame.pair.left.height) + ", the calibration is for " +
                          std::to_string(rig.width) + "x" + std::to_string(rig.height));
    }
    writer.Add(frame);
    counts.Add(frame);
  }
  writer.Finish();
  std::filesystem::rename(unfinished.path(), options.log);
  counts.Print(options.log);
}

void Convert(const ConvertOptions& options) {
  namespace fs = std::filesystem;
  if (fs::exists(options.log) && !options.overwrite) {
    throw UsageError(options.log.string() + ": exists; --overwrite replaces it");
  }
  if (options.side_by_side) return ConvertSideBySide(options);
  const std::unique_ptr<Sequence> sequence = OpenSequence(options.sequence);
  const SequenceInfo& info = sequence->info();
  for (const std::string& warning : info.warnings) std::fprintf(stderr, "note: %s\n", warning.c_str());
  if (info.calibration.left.model != info.calibration.right.model) {
    throw SequenceError(info.calibration.name + ": two distortion models, a log can carry one");
  }

  // Written beside and renamed at the end, so that the log may replace the one that it is made from.
  const UnfinishedFile unfinished(options.log.string() + ".unfinished");
  LcmLogWriter writer(unfinished.path(), info.calibration, TruePosesOf(info),
                      *ImageEncodingFromName(options.images));
  ConvertCounts counts;
  while (const std::optional<SensorFrame> frame = sequence->Next()) {
    writer.Add(*frame);
    counts.Add(*frame);
  }
  writer.Finish();
  fs::rename(unfinished.path(), options.log);
  counts.Print(options.log);
}

}  // namespace

void AddConvertCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("convert", "Write any sequence as an LCM log that gives the same map");
  auto options = std::make_shared<ConvertOptions>();
  command->add_option("SEQUENCE", options->sequence, "EuRoC ASL folder, KITTI odometry folder or LCM log")
      ->required();
  command->add_option("OUT", options->log, "the LCM log to write")->required();
  command
      ->add_option("--images", options->images,
                   "raw; lossless: smaller, the same pixels; mjpeg: smaller still, not the same pixels")
      ->check(CLI::IsMember({"raw", "lossless", "mjpeg"}))
      ->capture_default_str();
  command->add_flag("--overwrite", options->overwrite, "replace OUT");
  command->add_flag(
      "--side-by-side", options->side_by_side,
      "SEQUENCE holds both cameras in each image: a folder of images, named by frame or by time, or a video");
  command->add_option(
      "--calibration", options->calibration,
      "with --side-by-side: files of any tool that terrace calibration reads, commas between");
  command
      ->add_option("--rate", options->rate_hz,
                   "with --side-by-side: frames a second; else the names or the video tell it, or it is 30")
      ->check(CLI::Range(0.1, 1000.0));
  command->callback([options] { Convert(*options); });
}

}  // namespace terrace
