// SPDX-License-Identifier: BSD-3-Clause
#include "tools/camera_pairs.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/file_bytes.h"
#include "datasets/image_file.h"

namespace terrace {
namespace {

// More than a device can be behind the other.
constexpr std::size_t kMaxWaiting = 8;

void RequireBytes(const RawFrame& frame, std::size_t needed) {
  if (frame.data.size() >= needed) return;
  throw FileError("a frame of " + std::to_string(frame.data.size()) + " bytes, " + std::to_string(needed) +
                  " are needed for " + std::to_string(frame.width) + "x" + std::to_string(frame.height));
}

/// Every `step`th byte from `first` on of every row.
GrayImage Picked(const std::vector<std::uint8_t>& data, int row_bytes, int height, int first, int step,
                 int width) {
  GrayImage image{width, height, {}};
  image.data.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  auto out = image.data.begin();
  for (int v = 0; v < height; ++v) {
    const std::uint8_t* row = data.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(row_bytes);
    for (int u = 0; u < width; ++u) *out++ = row[first + u * step];
  }
  return image;
}

StereoPair Split(const RawFrame& frame) {
  StereoPair pair;
  if (frame.format == PixelFormat::kY8i) {
    RequireBytes(frame, 2 * static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
    pair.left = Picked(frame.data, 2 * frame.width, frame.height, 0, 2, frame.width);
    pair.right = Picked(frame.data, 2 * frame.width, frame.height, 1, 2, frame.width);
    return pair;
  }
  const GrayImage both = ToGray(frame);
  const int width = both.width / 2;
  pair.left = Picked(both.data, both.width, both.height, 0, 1, width);
  pair.right = Picked(both.data, both.width, both.height, width, 1, width);
  return pair;
}

/// Runs what may fail on bytes; the pair then says why.
template <typename Make>
StereoPair PairOrProblem(Make make) {
  StereoPair pair;
  try {
    return make();
  } catch (const FileError& error) {
    pair.problem = error.what();
  }
  return pair;
}

}  // namespace

const char* Name(PixelFormat format) {
  switch (format) {
    case PixelFormat::kGrey:
      return "GREY";
    case PixelFormat::kYuyv:
      return "YUYV";
    case PixelFormat::kMjpeg:
      return "MJPEG";
    case PixelFormat::kY8i:
      return "Y8I";
  }
  return "?";
}

std::optional<PixelFormat> PixelFormatFromName(const std::string& name) {
  for (const PixelFormat format :
       {PixelFormat::kGrey, PixelFormat::kYuyv, PixelFormat::kMjpeg, PixelFormat::kY8i})
    if (name == Name(format)) return format;
  return std::nullopt;
}

GrayImage ToGray(const RawFrame& frame) {
  const auto num_pixels = static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height);
  switch (frame.format) {
    case PixelFormat::kGrey:
      RequireBytes(frame, num_pixels);
      return Picked(frame.data, frame.width, frame.height, 0, 1, frame.width);
    case PixelFormat::kYuyv:
      RequireBytes(frame, 2 * num_pixels);
      return Picked(frame.data, 2 * frame.width, frame.height, 0, 2, frame.width);
    case PixelFormat::kY8i:
      RequireBytes(frame, 2 * num_pixels);
      return Picked(frame.data, 2 * frame.width, frame.height, 0, 1, 2 * frame.width);
    case PixelFormat::kMjpeg:
      break;
  }
  GrayImage image = DecodeGrayImage(frame.data, "a frame of the camera");
  if (image.width != frame.width || image.height != frame.height) {
    throw FileError("a JPEG image of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                    " instead of " + std::to_string(frame.width) + "x" + std::to_string(frame.height));
  }
  return image;
}

Timestamp PairMaker::MiddleOfExposure(const RawFrame& frame) const {
  const double half_s = 0.5e-6 * config_.exposure_us;
  const double s = (frame.t_is_begin ? half_s : -half_s) + 1e-3 * config_.stamp_offset_ms;
  return frame.t + std::chrono::nanoseconds(std::llround(1e9 * s));
}

std::optional<StereoPair> PairMaker::Add(int device, RawFrame frame) {
  std::optional<std::uint32_t>& last = last_sequence_[device];
  // A device that was started anew counts anew.
  if (last && frame.sequence > *last) num_lost_ += frame.sequence - *last - 1;
  last = frame.sequence;
  if (!config_.has_two_devices()) {
    StereoPair pair = PairOrProblem([&] { return Split(frame); });
    if (config_.swap) std::swap(pair.left, pair.right);
    pair.t_capture = MiddleOfExposure(frame);
    return pair;
  }
  waiting_[device].push_back(std::move(frame));
  return Match();
}

std::optional<StereoPair> PairMaker::Match() {
  auto& lefts = waiting_[0];
  auto& rights = waiting_[1];
  std::optional<StereoPair> pair;
  while (!pair && !lefts.empty() && !rights.empty()) {
    const double skew_ms = 1e3 * Seconds(lefts.front().t - rights.front().t);
    if (std::abs(skew_ms) > config_.max_skew_ms) {
      // Stamps increase: the older one of the two will find no partner any more.
      (skew_ms < 0.0 ? lefts : rights).pop_front();
      ++num_unmatched_;
      continue;
    }
    pair = PairOrProblem([&] {
      StereoPair both;
      both.left = ToGray(lefts.front());
      both.right = ToGray(rights.front());
      return both;
    });
    if (config_.swap) std::swap(pair->left, pair->right);
    const Timestamp t_left = MiddleOfExposure(lefts.front()), t_right = MiddleOfExposure(rights.front());
    pair->t_capture = t_left + (t_right - t_left) / 2;
    lefts.pop_front();
    rights.pop_front();
  }
  // One device alone must not fill the memory.
  for (auto& waiting : waiting_) {
    if (waiting.size() <= kMaxWaiting) continue;
    waiting.pop_front();
    ++num_unmatched_;
  }
  return pair;
}

}  // namespace terrace
