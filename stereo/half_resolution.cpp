// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/half_resolution.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {
constexpr float kMaxSlope = 1.0f;  // half-resolution pixels between neighbours on one surface
}

void HalveImage(const cv::Mat1b& image, cv::Mat1b& half) {
  cv::Mat1b even = image;
  if (image.cols % 2 != 0 || image.rows % 2 != 0)
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  cv::resize(even, half, {even.cols / 2, even.rows / 2}, 0, 0, cv::INTER_AREA);
}

void DoubleDisparity(const cv::Mat1f& half, cv::Mat1f& full) {
  for (int v = 0; v < full.rows; ++v) {
    // Row v lies a quarter of a halved pixel from row v / 2 towards this neighbour.
    const int near_row = v / 2;
    const int far_row = std::clamp(v % 2 == 0 ? near_row - 1 : near_row + 1, 0, half.rows - 1);
    const float* n = half[near_row];
    const float* f = half[far_row];
    for (int u = 0; u < full.cols; ++u) {
      const int i = u / 2, j = std::clamp(u % 2 == 0 ? i - 1 : i + 1, 0, half.cols - 1);
      const float a = n[i], b = n[j], c = f[i], d = f[j];
      // Comparisons with NaN are false: an unknown neighbour is not smooth.
      const bool smooth =
          std::abs(b - a) <= kMaxSlope && std::abs(c - a) <= kMaxSlope && std::abs(d - a) <= kMaxSlope;
      full(v, u) = 2.0f * (smooth ? 0.5625f * a + 0.1875f * (b + c) + 0.0625f * d : a);
    }
  }
}

}  // namespace terrace
