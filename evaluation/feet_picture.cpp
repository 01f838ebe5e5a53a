// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/feet_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <png.h>

#include "core/check.h"

namespace terrace {
namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kDropColour{0x1d, 0x21, 0x29};

constexpr double kPixel_m = 0.01;
constexpr int kMaxSide_px = 2000;
/// Half a pixel more than white space needs: the middle of a cell falls into the middle of a pixel.
constexpr double kMargin_m = 0.105;

Colour FootColour(FootCell::Kind kind) {
  switch (kind) {
    case FootCell::Kind::kMissed:
      return {0x4a, 0x8f, 0xe0};
    case FootCell::Kind::kOffered:
      return {0x7c, 0xc4, 0x80};
    case FootCell::Kind::kUnsupported:
      return {0xe0, 0x20, 0x20};
  }
  return {};
}

}  // namespace

ColourImage PictureOfFeet(const FeetEvaluation& feet) {
  Eigen::AlignedBox2d box;
  for (const FootCell& cell : feet.cells) box.extend(cell.middle);
  if (box.isEmpty()) return {};
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kMargin_m);
  box = Eigen::AlignedBox2d(box.min() - margin, box.max() + margin);
  const double pixel_m = std::max(kPixel_m, box.sizes().maxCoeff() / kMaxSide_px);
  ColourImage image;
  image.width = static_cast<int>(std::ceil(box.sizes().x() / pixel_m));
  image.height = static_cast<int>(std::ceil(box.sizes().y() / pixel_m));
  image.data.assign(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 255);
  const auto paint = [&](const Eigen::Vector2d& p, const Colour& colour) {
    const int u = static_cast<int>(std::floor((p.x() - box.min().x()) / pixel_m));
    const int v = static_cast<int>(std::floor((box.max().y() - p.y()) / pixel_m));
    if (u < 0 || v < 0 || u >= image.width || v >= image.height) return;
    std::copy(colour.begin(), colour.end(), image.Pixel(u, v));
  };
  for (const DropSample& drop : feet.drops) paint(drop.p.head<2>(), kDropColour);
  for (const FootCell& cell : feet.cells) paint(cell.middle, FootColour(cell.kind));
  return image;
}

std::vector<std::uint8_t> EncodePng(const ColourImage& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::uint8_t> bytes(size);
  TERRACE_CHECK(png_image_write_to_memory(&png, bytes.data(), &size, 0, image.data.data(), 0, nullptr) != 0,
                image.width, image.height);
  bytes.resize(size);
  return bytes;
}

}  // namespace terrace
