// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <terrace/images_t.hpp>

#include "core/sensor_frame.h"

namespace terrace {

/// How images travel in images_t.
enum class ImageEncoding {
  kRaw,       ///< GRAY
  kLossless,  ///< GRAY_ZSTD
  kMjpeg,     ///< MJPEG, quality 95: smaller, but not the same pixels
};
std::optional<ImageEncoding> ImageEncodingFromName(const std::string& name);  ///< "raw", "lossless", "mjpeg"

/// A pair with a problem becomes two empty images with the problem as metadata.
images_t ToMessage(const StereoPair& pair, ImageEncoding encoding);

/// When the pair was taken, without a look at its pixels; none when that cannot be.
std::optional<Timestamp> CaptureTime(const images_t& message);

/// Never fails: when the images cannot be used, the pair's `problem` says why, and it has no images.
StereoPair FromMessage(const images_t& message);

}  // namespace terrace
