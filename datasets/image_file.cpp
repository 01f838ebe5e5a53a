// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/image_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>

#include "core/check.h"
#include "datasets/image_format.h"

namespace terrace {
namespace {

std::optional<ImageFormat> FormatOf(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (bytes.size() >= 8 && std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin())) {
    return ImageFormat::kPng;
  }
  if (bytes.size() >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff)
    return ImageFormat::kJpeg;
  if (bytes.size() >= 3 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6')) return ImageFormat::kPnm;
  return std::nullopt;
}

constexpr const char* kNoKnownFormat = "neither PNG nor JPEG nor binary PNM";

}  // namespace

void RefuseImage(const std::string& name, const std::string& why) { throw FileError(name + ": " + why); }

void CheckImageSize(std::int64_t width, std::int64_t height, const std::string& name) {
  if (width < 1 || height < 1 || width > kMaxImageSidePx || height > kMaxImageSidePx) {
    RefuseImage(name, "image of " + std::to_string(width) + "x" + std::to_string(height) +
                          " must lie within 1x1 and " + std::to_string(kMaxImageSidePx) + "x" +
                          std::to_string(kMaxImageSidePx));
  }
}

const char* Name(ImageFormat format) {
  switch (format) {
    case ImageFormat::kPng:
      return "PNG";
    case ImageFormat::kJpeg:
      return "JPEG";
    case ImageFormat::kPnm:
      return "PNM";
  }
  TERRACE_CHECK(false, static_cast<int>(format));
}

GrayImage DecodeGrayImage(std::span<const std::uint8_t> bytes, const std::string& name) {
  const std::optional<ImageFormat> format = FormatOf(bytes);
  if (format == ImageFormat::kPng) return DecodePng(bytes, name);
  if (format == ImageFormat::kJpeg) return DecodeJpeg(bytes, name);
  if (format == ImageFormat::kPnm) return DecodePnm(bytes, name);
  RefuseImage(name, kNoKnownFormat);
}

GrayImage ReadGrayImage(const std::filesystem::path& path) {
  return DecodeGrayImage(ReadFileBytes(path), path.string());
}

Gray16Image ReadGray16Png(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  if (FormatOf(bytes) != ImageFormat::kPng) RefuseImage(path.string(), "not a PNG");
  return DecodeGray16Png(bytes, path.string());
}

ImageHeader ReadImageHeader(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  const std::string name = path.string();
  const std::optional<ImageFormat> format = FormatOf(bytes);
  if (format == ImageFormat::kPng) return ReadPngHeader(bytes, name);
  if (format == ImageFormat::kJpeg) return ReadJpegHeader(bytes, name);
  if (format == ImageFormat::kPnm) return ReadPnmHeader(bytes, name);
  RefuseImage(name, kNoKnownFormat);
}

bool IsImageFile(const std::filesystem::path& path) {
  std::array<char, 8> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return FormatOf({reinterpret_cast<const std::uint8_t*>(head.data()), head.size()}).has_value();
}

void WritePng(const std::filesystem::path& path, const GrayImage& image) {
  WriteFileBytes(path, EncodePng(image));
}

void WritePng(const std::filesystem::path& path, const Gray16Image& image) {
  WriteFileBytes(path, EncodePng(image));
}

}  // namespace terrace
