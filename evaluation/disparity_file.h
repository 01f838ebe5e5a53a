// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace terrace {

/// One number a pixel, row-major; NaN = unknown.
struct FloatImage {
  int width = 0;
  int height = 0;
  std::vector<float> data;

  FloatImage() = default;
  FloatImage(int columns, int rows);  ///< all unknown
  std::size_t Index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }
  float& At(int u, int v) { return data[Index(u, v)]; }
  float At(int u, int v) const { return data[Index(u, v)]; }
};

/// A disparity image [px]: a .pfm (infinity or NaN = unknown), or a .png whose values are `scale` times the
/// disparity (0 = unknown). Without a scale a 16-bit .png has 256, and one of 8 bits is refused, for there is
/// no custom. Throws FileError or ImageError.
FloatImage ReadDisparityFile(const std::filesystem::path& path, std::optional<double> scale = std::nullopt);

}  // namespace terrace
