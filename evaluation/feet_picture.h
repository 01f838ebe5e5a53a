// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "evaluation/feet_evaluation.h"

namespace terrace {

/// Three bytes a pixel: red, green, blue.
struct ColourImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> data;

  std::uint8_t* Pixel(int u, int v) { return data.data() + 3 * (static_cast<std::size_t>(v) * width + u); }
  const std::uint8_t* Pixel(int u, int v) const {
    return data.data() + 3 * (static_cast<std::size_t>(v) * width + u);
  }
};

/// The plan from above, x to the right, y up, a pixel a square centimetre (larger when it would not fit into
/// 2000 x 2000 pixels): footholds green, those that nothing carries red, well seen ground without a foothold
/// blue, drops black on white. Empty when there is nothing to show.
ColourImage PictureOfFeet(const FeetEvaluation& feet);

/// A PNG file of it.
std::vector<std::uint8_t> EncodePng(const ColourImage& image);

}  // namespace terrace
