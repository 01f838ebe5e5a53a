// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <cstddef>
#include <vector>

#include "datasets/image_format.h"

namespace terrace {
namespace {

struct PnmHeader {
  ImageHeader image;
  int max_value = 255;
  std::size_t data_begin = 0;
};

PnmHeader ReadHeaderOfPnm(std::span<const std::uint8_t> bytes, const std::string& name) {
  std::size_t i = 2;
  const auto next_number = [&]() -> std::int64_t {
    while (i < bytes.size() && (std::isspace(bytes[i]) != 0 || bytes[i] == '#')) {
      if (bytes[i] == '#') {
        while (i < bytes.size() && bytes[i] != '\n') ++i;
      } else {
        ++i;
      }
    }
    std::int64_t value = 0;
    const std::size_t begin = i;
    for (; i < bytes.size() && std::isdigit(bytes[i]) != 0 && i - begin < 9; ++i)
      value = 10 * value + bytes[i] - '0';
    if (i == begin)
      RefuseImage(name, "not a readable PNM: the header holds no width, height and largest value");
    return value;
  };
  const std::int64_t width = next_number();
  const std::int64_t height = next_number();
  const std::int64_t max_value = next_number();
  CheckImageSize(width, height, name);
  if (max_value < 1 || max_value > 65535)
    RefuseImage(name, "not a readable PNM: the largest value must be 1 to 65535");
  return {{ImageFormat::kPnm, static_cast<int>(width), static_cast<int>(height), max_value > 255 ? 16 : 8,
           bytes[1] == '6' ? 3 : 1},
          static_cast<int>(max_value),
          i + 1};
}

}  // namespace

ImageHeader ReadPnmHeader(std::span<const std::uint8_t> bytes, const std::string& name) {
  return ReadHeaderOfPnm(bytes, name).image;
}

GrayImage DecodePnm(std::span<const std::uint8_t> bytes, const std::string& name) {
  const PnmHeader header = ReadHeaderOfPnm(bytes, name);
  const std::size_t num_pixels = static_cast<std::size_t>(header.image.width) * header.image.height;
  const int sample_bytes = header.max_value > 255 ? 2 : 1;
  if (header.data_begin > bytes.size() ||
      num_pixels * header.image.channels * sample_bytes > bytes.size() - header.data_begin) {
    RefuseImage(name, "not a readable PNM: the file ends early");
  }
  const std::uint8_t* in = bytes.data() + header.data_begin;
  const auto next_sample = [&] {
    const int value = sample_bytes == 2 ? 256 * in[0] + in[1] : in[0];
    in += sample_bytes;
    return (255 * std::min(value, header.max_value) + header.max_value / 2) / header.max_value;
  };
  GrayImage image{header.image.width, header.image.height, std::vector<std::uint8_t>(num_pixels)};
  for (std::uint8_t& pixel : image.data) {
    const int first = next_sample();
    if (header.image.channels == 1) {
      pixel = static_cast<std::uint8_t>(first);
    } else {
      const int green = next_sample();
      pixel = Luma(first, green, next_sample());
    }
  }
  return image;
}

}  // namespace terrace
