// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/file_bytes.h"
#include "core/sensor_frame.h"

namespace terrace {

/// No image may be wider or higher; a header that says otherwise is refused before anything is allocated.
inline constexpr int kMaxImageSidePx = 16384;

/// 16-bit grey as stored (depth, labels, disparity), row-major without padding.
struct Gray16Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> data;

  bool empty() const { return data.empty(); }
};

enum class ImageFormat { kPng, kJpeg, kPnm };
const char* Name(ImageFormat format);  ///< "PNG", "JPEG", "PNM"

/// What the first bytes of an image file say.
struct ImageHeader {
  ImageFormat format = ImageFormat::kPng;
  int width = 0;
  int height = 0;
  int bits = 8;      ///< a sample
  int channels = 1;  ///< alpha included; of a palette's entries
};

/// Any PNG, JPEG or binary PNM (P5, P6) as 8-bit grey: colour by the luma weights of BT.601, 16 bits scaled
/// to 8 (of which the upper ones must be used), alpha ignored. A truncated or damaged file is refused as a
/// whole, never half read. Throws FileError.
GrayImage ReadGrayImage(const std::filesystem::path& path);

/// The same from memory; `name` stands for the file in messages.
GrayImage DecodeGrayImage(std::span<const std::uint8_t> bytes, const std::string& name);

/// A grey PNG of 8 or 16 bits with its values unchanged. Throws FileError, also for colour.
Gray16Image ReadGray16Png(const std::filesystem::path& path);

/// Throws FileError, also when the size is out of bounds.
ImageHeader ReadImageHeader(const std::filesystem::path& path);

/// True when the first bytes are those of a format that can be read.
bool IsImageFile(const std::filesystem::path& path);

/// @param compression  of zlib: 1 is fastest, 9 smallest. The same image gives the same bytes.
std::vector<std::uint8_t> EncodePng(const GrayImage& image, int compression = 3);
std::vector<std::uint8_t> EncodePng(const Gray16Image& image, int compression = 3);
/// @param quality  1 to 100.
std::vector<std::uint8_t> EncodeJpeg(const GrayImage& image, int quality);

/// Throw FileError when the file cannot be written.
void WritePng(const std::filesystem::path& path, const GrayImage& image);
void WritePng(const std::filesystem::path& path, const Gray16Image& image);

}  // namespace terrace
