// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/disparity_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "core/file_bytes.h"
#include "datasets/image_file.h"

namespace terrace {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr double kSixteenBitScale = 256.0;

/// A grey .pfm: "Pf", width, height, a scale whose sign says the byte order, one white space, then the rows
/// from the lowest up.
FloatImage ReadPfm(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  constexpr std::size_t kMaxHeader = 128;
  const std::string head(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kMaxHeader));
  std::istringstream words(head);
  std::string magic;
  int width = 0, height = 0;
  double scale = 0.0;
  words >> magic >> width >> height >> scale;
  if (!words || magic != "Pf" || scale == 0.0) throw FileError(path.string() + ": is not a grey .pfm image");
  if (width < 1 || height < 1 || width > kMaxImageSidePx || height > kMaxImageSidePx) {
    throw FileError(path.string() + ": the image is empty or too large");
  }
  const auto begin = static_cast<std::size_t>(words.tellg()) + 1;
  const std::size_t row_bytes = static_cast<std::size_t>(width) * sizeof(float);
  if (begin > bytes.size() || bytes.size() - begin < row_bytes * static_cast<std::size_t>(height)) {
    throw FileError(path.string() + ": is cut off");
  }
  const bool swap = (scale < 0.0) != (std::endian::native == std::endian::little);
  FloatImage image(width, height);
  for (int v = 0; v < height; ++v) {
    const std::uint8_t* row = bytes.data() + begin + row_bytes * static_cast<std::size_t>(height - 1 - v);
    for (int u = 0; u < width; ++u) {
      std::uint8_t value[sizeof(float)];
      std::memcpy(value, row + static_cast<std::size_t>(u) * sizeof(float), sizeof(float));
      if (swap) std::reverse(std::begin(value), std::end(value));
      float number;
      std::memcpy(&number, value, sizeof(float));
      image.At(u, v) = std::isfinite(number) ? number : kUnknown;
    }
  }
  return image;
}

struct PngKind {
  int bits = 0;
  bool colour = false;
};

/// From the header chunk, which is always first.
PngKind KindOfPng(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  constexpr std::size_t kBitDepthAt = 24, kColourTypeAt = 25;
  if (bytes.size() <= kColourTypeAt) throw FileError(path.string() + ": is not a PNG");
  return {bytes[kBitDepthAt], bytes[kColourTypeAt] != 0};
}

template <typename Image>
FloatImage Scaled(const Image& image, double scale) {
  FloatImage scaled(image.width, image.height);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    if (image.data[i] != 0) scaled.data[i] = static_cast<float>(image.data[i] / scale);
  }
  return scaled;
}

}  // namespace

FloatImage::FloatImage(int columns, int rows)
    : width(columns),
      height(rows),
      data(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), kUnknown) {}

FloatImage ReadDisparityFile(const std::filesystem::path& path, std::optional<double> scale) {
  if (path.extension() == ".pfm") {
    FloatImage image = ReadPfm(path);
    for (float& value : image.data) value /= static_cast<float>(scale.value_or(1.0));
    return image;
  }
  const PngKind kind = KindOfPng(path);
  if (kind.bits == 16 && !kind.colour) return Scaled(ReadGray16Png(path), scale.value_or(kSixteenBitScale));
  if (!scale) throw FileError(path.string() + ": an 8-bit disparity image needs its scale");
  // The Middlebury images of 2001 to 2003 are grey stored as colour.
  return Scaled(ReadGrayImage(path), *scale);
}

}  // namespace terrace
