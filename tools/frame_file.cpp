// SPDX-License-Identifier: BSD-3-Clause
#include "tools/frame_file.h"

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

namespace terrace {
namespace {

constexpr std::size_t kNumValues = 6, kHeaderBytes = 8 * kNumValues;

void AppendValue(std::int64_t value, std::vector<std::uint8_t>* out) {
  for (int shift = 56; shift >= 0; shift -= 8) out->push_back(static_cast<std::uint8_t>(value >> shift));
}

std::int64_t ValueAt(const std::vector<std::uint8_t>& data, std::size_t index) {
  std::uint64_t value = 0;
  for (std::size_t i = 8 * index; i < 8 * index + 8; ++i) value = value << 8 | data[i];
  return static_cast<std::int64_t>(value);
}

std::string ChannelOfDevice(int device) { return "CAMERA" + std::to_string(device); }

/// None: it is no frame.
std::optional<RawFrame> FrameOf(const LcmEvent& event) {
  constexpr std::int64_t kMaxSide = 16384;
  if (event.data.size() < kHeaderBytes) return std::nullopt;
  std::array<std::int64_t, kNumValues> values{};
  for (std::size_t i = 0; i < kNumValues; ++i) values[i] = ValueAt(event.data, i);
  const auto [format, is_begin, width, height, sequence, t_ns] = values;
  if (format < 0 || format > static_cast<int>(PixelFormat::kY8i) || width <= 0 || height <= 0 ||
      width > kMaxSide || height > kMaxSide)
    return std::nullopt;
  RawFrame frame;
  frame.format = static_cast<PixelFormat>(format);
  frame.t_is_begin = is_begin != 0;
  frame.width = static_cast<int>(width);
  frame.height = static_cast<int>(height);
  frame.sequence = static_cast<std::uint32_t>(sequence);
  frame.t.ns = t_ns;
  frame.data.assign(event.data.begin() + kHeaderBytes, event.data.end());
  return frame;
}

}  // namespace

void FrameFileWriter::Add(int device, const RawFrame& frame) {
  std::vector<std::uint8_t> data;
  data.reserve(kHeaderBytes + frame.data.size());
  for (const std::int64_t value :
       {static_cast<std::int64_t>(frame.format), std::int64_t{frame.t_is_begin}, std::int64_t{frame.width},
        std::int64_t{frame.height}, std::int64_t{frame.sequence}, frame.t.ns})
    AppendValue(value, &data);
  data.insert(data.end(), frame.data.begin(), frame.data.end());
  log_.Write(frame.t.utime(), ChannelOfDevice(device), data);
}

RecordedFrames::RecordedFrames(const std::filesystem::path& path, int device,
                               std::chrono::steady_clock::time_point start)
    : log_(path), channel_(ChannelOfDevice(device)), start_(start) {
  ReadAhead();
}

void RecordedFrames::ReadAhead() {
  LcmEvent event;
  while (log_.Next(&event)) {
    std::optional<RawFrame> frame = FrameOf(event);
    if (!frame) continue;
    if (!t_first_) t_first_ = frame->t;
    if (event.channel != channel_) continue;
    next_ = std::move(frame);
    return;
  }
  ended_ = true;
}

std::optional<RawFrame> RecordedFrames::Next(int patience_ms) {
  if (!next_) return std::nullopt;
  const auto due = start_ + (next_->t - *t_first_);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(patience_ms);
  std::this_thread::sleep_until(std::min(due, end));
  if (due > end) return std::nullopt;
  std::optional<RawFrame> frame = std::exchange(next_, std::nullopt);
  ReadAhead();
  return frame;
}

}  // namespace terrace
