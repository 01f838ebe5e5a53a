// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/half_resolution.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/parallel_for.h"
#include "stereo/disparity_units.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/half_resolution.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr float kMaxSlope = 1.0f;  // half-resolution pixels between neighbours on one surface

/// One row of twice as many pixels, a quarter of a pixel from `near` towards `far`. Both have one more pixel
/// on either side, and a vector behind.
void DoubleRow(const float* near, const float* far, int width, float* doubled) {
  const hn::ScalableTag<float> df;
  const auto slope = hn::Set(df, kMaxSlope);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto a = hn::LoadU(df, near + u), c = hn::LoadU(df, far + u);
    // A quarter of the way from a towards its neighbour b and towards c (d is both ways); a itself at a depth
    // edge.
    const auto towards = [&](int side) HWY_ATTR {
      const auto b = hn::LoadU(df, near + u + side), d = hn::LoadU(df, far + u + side);
      // Comparisons with NaN are false: an unknown neighbour is not smooth.
      const auto like_a = [&](hn::Vec<decltype(df)> other)
                              HWY_ATTR { return hn::Le(hn::Abs(hn::Sub(other, a)), slope); };
      const auto mean =
          hn::Add(hn::Add(hn::Mul(hn::Set(df, 0.5625f), a), hn::Mul(hn::Set(df, 0.1875f), hn::Add(b, c))),
                  hn::Mul(hn::Set(df, 0.0625f), d));
      const auto smooth = hn::IfThenElse(hn::And(hn::And(like_a(b), like_a(c)), like_a(d)), mean, a);
      return hn::Add(smooth, smooth);
    };
    hn::StoreInterleaved2(towards(-1), towards(1), df, doubled + 2 * u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(DoubleRow);

namespace {

float PxOfUnits(std::int16_t units) { return static_cast<float>(units) / UnitImage::kUnitsPerPx; }

/// Moves the row `far` to the row `near`, so many rows below it, along the slopes; those of pixels that then
/// fit worse become 0.
void AlongSlopes(const float* near, int rows_below, int width, std::int16_t* slopes, float* far) {
  for (int u = 0; u < width; ++u) {
    const float moved = far[u] + static_cast<float>(rows_below) * PxOfUnits(slopes[u]);
    if (std::abs(moved - near[u]) > std::abs(far[u] - near[u]))
      slopes[u] = 0;
    else
      far[u] = moved;
  }
  far[-1] = far[0];
  far[width] = far[width - 1];
}

}  // namespace

void HalveImage(const cv::Mat1b& image, cv::Mat1b& half) {
  cv::Mat1b even = image;
  if (image.cols % 2 != 0 || image.rows % 2 != 0)
    cv::copyMakeBorder(image, even, 0, image.rows % 2, 0, image.cols % 2, cv::BORDER_REPLICATE);
  cv::resize(even, half, {even.cols / 2, even.rows / 2}, 0, 0, cv::INTER_AREA);
}

void DoubleDisparity(const cv::Mat1f& half, cv::Mat1f& full, const SteepSurfaces& steep) {
  // Rows with their first and last pixel repeated, and the doubled row, each with room for a vector behind
  // it.
  constexpr int kBehind = 64;
  const auto repeat_ends = [&](const float* from, std::vector<float>& to) {
    std::copy_n(from, half.cols, to.begin() + 1);
    to.front() = to[1];
    to[half.cols + 1] = to[half.cols];
  };
  ParallelForPieces(static_cast<std::size_t>(full.rows), [&](std::size_t begin, std::size_t end) {
    std::vector<float> near_row(half.cols + 2 + kBehind), far_row(half.cols + 2 + kBehind);
    std::vector<float> doubled(2 * (half.cols + kBehind));
    std::vector<std::int16_t> slopes(half.cols + kBehind);
    for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
      // Row v lies a quarter of a halved pixel from row v / 2 towards its neighbour above or below.
      repeat_ends(half[v / 2], near_row);
      const int v_far = std::clamp(v % 2 == 0 ? v / 2 - 1 : v / 2 + 1, 0, half.rows - 1);
      repeat_ends(half[v_far], far_row);
      const bool any_steep = steep.SlopesOfRow(v / 2, 1, half.cols, slopes.data());
      if (any_steep)
        AlongSlopes(near_row.data() + 1, v / 2 - v_far, half.cols, slopes.data(), far_row.data() + 1);
      HWY_DYNAMIC_DISPATCH(DoubleRow)(near_row.data() + 1, far_row.data() + 1, half.cols, doubled.data());
      // A quarter of a row further, twice the disparity.
      for (int u = 0; any_steep && u < 2 * half.cols; ++u)
        doubled[u] += 0.5f * static_cast<float>(v_far - v / 2) * PxOfUnits(slopes[u / 2]);
      std::copy_n(doubled.begin(), full.cols, full[v]);
    }
  });
}

}  // namespace terrace
#endif  // HWY_ONCE
