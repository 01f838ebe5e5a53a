// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "datasets/image_file.h"

// One file a format behind image_file.h. `name` stands for the file in messages; each function throws
// FileError.

namespace terrace {

[[noreturn]] void RefuseImage(const std::string& name, const std::string& why);
/// Before anything is allocated for it.
void CheckImageSize(std::int64_t width, std::int64_t height, const std::string& name);

/// Luma of BT.601 in 14-bit fixed point; the weights add up to one exactly.
inline std::uint8_t Luma(int r, int g, int b) {
  return static_cast<std::uint8_t>((4899 * r + 9617 * g + 1868 * b + 8192) >> 14);
}

ImageHeader ReadPngHeader(std::span<const std::uint8_t> bytes, const std::string& name);
GrayImage DecodePng(std::span<const std::uint8_t> bytes, const std::string& name);
/// A grey PNG's values unchanged.
Gray16Image DecodeGray16Png(std::span<const std::uint8_t> bytes, const std::string& name);

ImageHeader ReadJpegHeader(std::span<const std::uint8_t> bytes, const std::string& name);
GrayImage DecodeJpeg(std::span<const std::uint8_t> bytes, const std::string& name);

ImageHeader ReadPnmHeader(std::span<const std::uint8_t> bytes, const std::string& name);
GrayImage DecodePnm(std::span<const std::uint8_t> bytes, const std::string& name);

}  // namespace terrace
