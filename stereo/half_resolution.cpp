// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/half_resolution.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

constexpr float kMaxSlope = 1.0f;  // half-resolution pixels between neighbours on one surface

/// A quarter of the way from a towards b and towards c (d is both ways); a itself at a depth edge.
inline float Interpolate(float a, float b, float c, float d) {
  // Comparisons with NaN are false: an unknown neighbour is not smooth.
  const bool smooth =
      (std::abs(b - a) <= kMaxSlope) & (std::abs(c - a) <= kMaxSlope) & (std::abs(d - a) <= kMaxSlope);
  const float mean = 0.5625f * a + 0.1875f * (b + c) + 0.0625f * d;
  return smooth ? mean : a;
}

}  // namespace

void HalveImage(const cv::Mat1b& image, cv::Mat1b& half) {
  cv::Mat1b even = image;
  if (image.cols % 2 != 0 || image.rows % 2 != 0)
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  cv::resize(even, half, {even.cols / 2, even.rows / 2}, 0, 0, cv::INTER_AREA);
}

void DoubleDisparity(const cv::Mat1f& half, cv::Mat1f& full) {
  // Rows with their first and last pixel repeated, and the doubled row: plain loops that compilers turn into
  // vectors.
  std::vector<float> near_row(half.cols + 2), far_row(half.cols + 2), doubled(2 * half.cols);
  const auto repeat_ends = [&](const float* from, std::vector<float>& to) {
    std::copy_n(from, half.cols, to.begin() + 1);
    to.front() = to[1];
    to.back() = to[half.cols];
  };
  for (int v = 0; v < full.rows; ++v) {
    // Row v lies a quarter of a halved pixel from row v / 2 towards its neighbour above or below.
    repeat_ends(half[v / 2], near_row);
    repeat_ends(half[std::clamp(v % 2 == 0 ? v / 2 - 1 : v / 2 + 1, 0, half.rows - 1)], far_row);
    const float* n = near_row.data() + 1;
    const float* f = far_row.data() + 1;
    for (int i = 0; i < half.cols; ++i) {
      doubled[2 * i] = 2.0f * Interpolate(n[i], n[i - 1], f[i], f[i - 1]);
      doubled[2 * i + 1] = 2.0f * Interpolate(n[i], n[i + 1], f[i], f[i + 1]);
    }
    std::copy_n(doubled.begin(), full.cols, full[v]);
  }
}

}  // namespace terrace
