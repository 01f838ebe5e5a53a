// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "datasets/lcm_event_log.h"
#include "tools/camera_frame.h"

namespace terrace {

/// The buffers of a device as it filled them, in an LCM log: one event a frame on the channel "CAMERA" and
/// the number of the device. Data: format (0 GREY, 1 YUYV, 2 MJPEG, 3 Y8I), 1 where the stamp is the begin of
/// the exposure, width, height, sequence, stamp in ns, each 8 bytes big-endian, then the bytes of the buffer.
class FrameFileWriter {
 public:
  explicit FrameFileWriter(const std::filesystem::path& path) : log_(path) {}
  void Add(int device, const RawFrame& frame);
  /// Throws FileError when anything could not be written.
  void Close() { log_.Close(); }

 private:
  LcmEventWriter log_;
};

/// Plays the frames of one device at the pace at which they came.
class RecordedFrames : public FrameSource {
 public:
  /// Throws FileError.
  RecordedFrames(const std::filesystem::path& path, int device, std::chrono::steady_clock::time_point start);
  std::optional<RawFrame> Next(int patience_ms) override;
  bool ended() const override { return ended_; }

 private:
  void ReadAhead();

  LcmEventReader log_;
  const std::string channel_;
  const std::chrono::steady_clock::time_point start_;
  std::optional<Timestamp> t_first_;  // of the file, whatever the device
  std::optional<RawFrame> next_;
  bool ended_ = false;
};

}  // namespace terrace
