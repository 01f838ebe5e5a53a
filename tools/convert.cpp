// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "core/file_bytes.h"
#include "datasets/ground_truth.h"
#include "datasets/lcm_log_writer.h"
#include "datasets/sequence.h"
#include "tools/commands.h"

namespace terrace {
namespace {

struct ConvertOptions {
  std::filesystem::path sequence;
  std::filesystem::path log;
  std::string images = "raw";
  bool overwrite = false;
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

void Convert(const ConvertOptions& options) {
  namespace fs = std::filesystem;
  if (fs::exists(options.log) && !options.overwrite) {
    throw UsageError(options.log.string() + ": exists; --overwrite replaces it");
  }
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
  std::int64_t num_frames = 0, num_bad = 0, num_imu = 0, num_priors = 0;
  while (const std::optional<SensorFrame> frame = sequence->Next()) {
    writer.Add(*frame);
    ++num_frames;
    num_bad += frame->pair.problem.empty() ? 0 : 1;
    num_imu += static_cast<std::int64_t>(frame->samples.imu.size());
    num_priors += static_cast<std::int64_t>(frame->samples.priors.size());
  }
  writer.Finish();
  fs::rename(unfinished.path(), options.log);
  std::printf("%s: %lld stereo pairs (%lld unreadable), %lld IMU samples, %lld priors, %.1f MB\n",
              options.log.c_str(), static_cast<long long>(num_frames), static_cast<long long>(num_bad),
              static_cast<long long>(num_imu), static_cast<long long>(num_priors),
              static_cast<double>(fs::file_size(options.log)) * 1e-6);
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
  command->callback([options] { Convert(*options); });
}

}  // namespace terrace
