// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/folder_sequence.h"

#include <array>
#include <utility>

#include "core/check.h"
#include "datasets/frame_times.h"
#include "datasets/image_file.h"

namespace terrace {
namespace {

std::string SizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

std::string WrongSize(const std::filesystem::path& path, int width, int height,
                      const StereoCalibration& calibration) {
  return path.string() + ": image of " + SizeText(width, height) + ", must be " +
         SizeText(calibration.width, calibration.height) + " as in " + calibration.name;
}

}  // namespace

void ThrowIfAny(const std::vector<std::string>& problems) {
  if (problems.empty()) return;
  std::string text;
  for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
  throw SequenceError(text);
}

FolderSequence::FolderSequence(SequenceInfo info, std::vector<FolderFrame> frames, SensorSamples samples,
                               std::int64_t num_time_jumps)
    : info_(std::move(info)),
      frames_(std::move(frames)),
      samples_(std::move(samples)),
      num_time_jumps_(num_time_jumps) {
  TERRACE_CHECK(!frames_.empty());
  info_.num_frames = static_cast<std::int64_t>(frames_.size());
  info_.t_first = frames_.front().t_capture;
  info_.t_last = frames_.back().t_capture;
  std::vector<Timestamp> times;
  for (const FolderFrame& frame : frames_) times.push_back(frame.t_capture);
  if (const auto sentence = StrangeRate(times)) info_.warnings.push_back(*sentence);
  if (const auto sentence = OtherClockOfImu(times, samples_.imu)) info_.warnings.push_back(*sentence);
  CheckImageSizes();
}

void FolderSequence::CheckImageSizes() const {
  // A few frames tell a wrong calibration from a damaged image, which is reported when its turn comes.
  const std::size_t last = frames_.size() - 1;
  std::vector<std::string> problems;
  for (const auto side : {&FolderFrame::left, &FolderFrame::right}) {
    std::string problem;
    for (const std::size_t i : {std::size_t{0}, last / 4, last / 2, last}) {
      const std::filesystem::path& path = frames_[i].*side;
      if (path.empty()) continue;
      try {
        const ImageHeader image = ReadImageHeader(path);
        const bool right_size =
            image.width == info_.calibration.width && image.height == info_.calibration.height;
        problem = right_size ? "" : WrongSize(path, image.width, image.height, info_.calibration);
      } catch (const FileError& error) {
        problem = error.what();
      }
      if (problem.empty()) break;
    }
    if (!problem.empty()) problems.push_back(problem);
  }
  ThrowIfAny(problems);
}

std::optional<SensorFrame> FolderSequence::Next() {
  if (next_frame_ == frames_.size()) return std::nullopt;
  const FolderFrame& frame = frames_[next_frame_];
  SensorFrame out;
  out.frame_id = static_cast<FrameId>(next_frame_);
  out.pair = LoadPair(frame);
  out.samples = TakeSamplesUpTo(frame.t_capture);
  ++next_frame_;
  return out;
}

StereoPair FolderSequence::LoadPair(const FolderFrame& frame) const {
  StereoPair pair;
  pair.t_capture = frame.t_capture;
  pair.problem = frame.problem;
  if (!pair.problem.empty()) return pair;
  const std::array<std::pair<const std::filesystem::path*, GrayImage*>, 2> sides = {
      std::pair{&frame.left, &pair.left}, std::pair{&frame.right, &pair.right}};
  for (const auto& [path, image] : sides) {
    try {
      *image = ReadGrayImage(*path);
    } catch (const FileError& error) {
      pair.problem = error.what();
      break;
    }
    if (image->width != info_.calibration.width || image->height != info_.calibration.height) {
      pair.problem = WrongSize(*path, image->width, image->height, info_.calibration);
      break;
    }
  }
  if (!pair.problem.empty()) pair.left = pair.right = {};
  return pair;
}

SensorSamples FolderSequence::TakeSamplesUpTo(Timestamp t) {
  SensorSamples out;
  for (; next_imu_ < samples_.imu.size() && samples_.imu[next_imu_].t <= t; ++next_imu_) {
    out.imu.push_back(samples_.imu[next_imu_]);
  }
  for (; next_prior_ < samples_.priors.size() && samples_.priors[next_prior_].t <= t; ++next_prior_) {
    out.priors.push_back(samples_.priors[next_prior_]);
  }
  return out;
}

}  // namespace terrace
