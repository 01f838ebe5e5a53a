// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/camera_config.h"
#include "tools/camera_frame.h"

namespace terrace {

/// A video device of Linux (V4L2), streaming into memory that it shares with us.
class V4l2Camera : public FrameSource {
 public:
  /// Opens the device and starts it. Throws CameraGone when it is not there or busy, std::runtime_error with
  /// what the device offers instead when it cannot send what the configuration asks for.
  V4l2Camera(const std::string& device, const CameraConfig& config);
  ~V4l2Camera() override;
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  std::optional<RawFrame> Next(int patience_ms) override;
  /// What could not be set, a sentence each.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct Buffer {
    void* start = nullptr;
    std::size_t size = 0;
  };

  void RequireCapture();
  void SetFormat(const CameraConfig& config);
  void SetControls(const CameraConfig& config);
  void SetControl(std::uint32_t id, std::int64_t value, const char* name);
  void Start();
  void Stop();
  [[noreturn]] void Gone(const std::string& what) const;

  const std::string device_;
  int fd_ = -1;
  PixelFormat format_ = PixelFormat::kGrey;
  int width_ = 0;
  int height_ = 0;
  std::vector<Buffer> buffers_;
  std::vector<std::string> notes_;
};

/// A time on the monotonic clock, as drivers stamp, on the clock of the system.
/// @param monotonic_now, system_now  the two clocks, read at the same moment
constexpr Timestamp OnSystemClock(Timestamp monotonic, Timestamp monotonic_now, Timestamp system_now) {
  return system_now + (monotonic - monotonic_now);
}

}  // namespace terrace
