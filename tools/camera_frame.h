// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/time.h"

namespace terrace {

enum class PixelFormat {
  kGrey,   ///< 8 bits a pixel
  kYuyv,   ///< Y U Y V: every second byte is grey
  kMjpeg,  ///< one JPEG image
  kY8i,    ///< two cameras, byte by byte: left, right, left, ...
};
const char* Name(PixelFormat format);  ///< "GREY", "YUYV", "MJPEG", "Y8I"
std::optional<PixelFormat> PixelFormatFromName(const std::string& name);

/// What a device has handed over, as it is.
struct RawFrame {
  Timestamp t;             ///< on the clock of the system
  bool t_is_begin = true;  ///< of the exposure; false: its end
  PixelFormat format = PixelFormat::kGrey;
  int width = 0;  ///< px, of everything that the device sends as one image
  int height = 0;
  std::uint32_t sequence = 0;  ///< +1 a frame; a step of more: the driver has lost some
  std::vector<std::uint8_t> data;
};

/// The device does not answer, was unplugged or has gone silent; it may come back.
class CameraGone : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where frames come from: a device, or what was once recorded from one.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// None: nothing has come in this time. Throws CameraGone.
  virtual std::optional<RawFrame> Next(int patience_ms) = 0;
  /// Nothing will ever come again.
  virtual bool ended() const { return false; }
};

}  // namespace terrace
