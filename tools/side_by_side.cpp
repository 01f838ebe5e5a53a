// SPDX-License-Identifier: BSD-3-Clause
#include "tools/side_by_side.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "datasets/image_file.h"
#include "datasets/image_names.h"
#include "datasets/sequence.h"
#include "tools/camera_pairs.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

/// Of frames that are only counted nobody knows the day: the first minute of the epoch is as good as any.
constexpr std::int64_t kCountedFromNs = 60'000'000'000;
constexpr double kUsualRateHz = 30.0;

Timestamp Counted(std::int64_t frame, double rate_hz) {
  return Timestamp{kCountedFromNs + std::llround(1e9 * static_cast<double>(frame) / rate_hz)};
}

StereoPair HalvesOf(const std::string& name, GrayImage both) {
  StereoPair pair;
  if (both.width % 2 != 0) {
    pair.problem = name + ": an odd width cannot be two images side by side";
    return pair;
  }
  RawFrame frame;
  frame.width = both.width;
  frame.height = both.height;
  frame.data = std::move(both.data);
  return *PairMaker(CameraConfig{}).Add(0, std::move(frame));
}

NextPair OpenFolder(const fs::path& folder, std::optional<double> rate_hz) {
  const auto names = std::make_shared<const ImageNames>(ListImageNames(folder));
  if (names->by_number.empty()) {
    throw SequenceError(folder.string() +
                        ": holds no images that are named by frame or time, and is no video either");
  }
  const bool by_name = names->are_times && !rate_hz;
  return [=, at = names->by_number.begin()]() mutable -> std::optional<StereoPair> {
    if (at == names->by_number.end()) return std::nullopt;
    const auto& [number, name] = *at++;
    StereoPair pair;
    try {
      pair = HalvesOf(name, ReadGrayImage(folder / name));
    } catch (const FileError& error) {
      pair.problem = error.what();
    }
    pair.t_capture = by_name ? Timestamp{number} : Counted(number, rate_hz.value_or(kUsualRateHz));
    return pair;
  };
}

/// A video's own times, as long as they rise.
NextPair OpenVideo(const fs::path& file, std::optional<double> rate_hz) {
  const auto video = std::make_shared<cv::VideoCapture>();
  if (!video->open(file.string()))
    throw SequenceError(file.string() + ": is no folder of images and no video that can be decoded here");
  const double said_hz = video->get(cv::CAP_PROP_FPS);
  const double steady_hz = rate_hz.value_or(said_hz > 0.1 && said_hz < 1000.0 ? said_hz : kUsualRateHz);
  return [=, frame = std::int64_t{0}, last_ms = -1.0]() mutable -> std::optional<StereoPair> {
    cv::Mat3b colours;
    if (!video->read(colours)) return std::nullopt;
    cv::Mat1b grey;
    cv::cvtColor(colours, grey, cv::COLOR_BGR2GRAY);
    StereoPair pair = HalvesOf(file.string(), {grey.cols, grey.rows, {grey.begin(), grey.end()}});
    const double ms = video->get(cv::CAP_PROP_POS_MSEC);
    pair.t_capture = Counted(frame, steady_hz);
    if (!rate_hz && ms > last_ms) pair.t_capture.ns = kCountedFromNs + std::llround(1e6 * ms);
    last_ms = ms;
    ++frame;
    return pair;
  };
}

}  // namespace

NextPair OpenSideBySide(const fs::path& path, std::optional<double> rate_hz) {
  return fs::is_directory(path) ? OpenFolder(path, rate_hz) : OpenVideo(path, rate_hz);
}

}  // namespace terrace
