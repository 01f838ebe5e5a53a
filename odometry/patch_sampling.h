// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "odometry/float4.h"
#include "odometry/patch.h"

namespace terrace {

inline float Dot(const float* a, const float* b) {
  Float4 sum{};
  for (int i = 0; i < PatchTemplate::kArea; i += 4) sum += Load(a + i) * Load(b + i);
  return Sum(sum);
}
inline float Total(const float* a) {
  Float4 sum{};
  for (int i = 0; i < PatchTemplate::kArea; i += 4) sum += Load(a + i);
  return Sum(sum);
}

/// True when a bilinear sample can be taken at (x, y).
inline bool Inside(const cv::Mat1b& image, float x, float y) {
  return x >= 0.0f && y >= 0.0f && x < static_cast<float>(image.cols - 1) &&
         y < static_cast<float>(image.rows - 1);
}

/// Offsets from the centre of the samples of a square, row by row.
template <int kSide>
struct SquareOffsets {
  static constexpr int kCount = kSide * kSide;
  static_assert(kCount % 4 == 0);
  alignas(16) float u[kCount];
  alignas(16) float v[kCount];

  constexpr SquareOffsets() : u{}, v{} {
    for (int k = 0; k < kCount; ++k) {
      u[k] = static_cast<float>(k % kSide) - 0.5f * (kSide - 1);
      v[k] = static_cast<float>(k / kSide) - 0.5f * (kSide - 1);
    }
  }
};

/// Bilinear samples where `place(du, dv, x, y)` puts each offset; all of them must lie inside the image.
template <int kSide, typename Place>
void Sample(const cv::Mat1b& image, const SquareOffsets<kSide>& offsets, const Place& place, float* samples) {
  const std::uint8_t* const pixels = image.data;
  const auto step = static_cast<std::ptrdiff_t>(image.step);
  for (int k = 0; k < offsets.kCount; k += 4) {
    Float4 x, y;
    place(Load(offsets.u + k), Load(offsets.v + k), x, y);
    const Int4 ix = __builtin_convertvector(x, Int4);
    const Int4 iy = __builtin_convertvector(y, Int4);
    const Float4 fx = x - __builtin_convertvector(ix, Float4);
    const Float4 fy = y - __builtin_convertvector(iy, Float4);
    // Of each sample the four pixels around it, a byte each.
    const auto Around = [&](int i) {
      const std::uint8_t* const above = pixels + iy[i] * step + ix[i];
      const std::uint8_t* const below = above + step;
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(above[0] | above[1] << 8) |
                                       static_cast<std::uint32_t>(below[0] | below[1] << 8) << 16);
    };
    const Int4 four{Around(0), Around(1), Around(2), Around(3)};
    const auto Corner = [&four](int byte) {
      return __builtin_convertvector((four >> 8 * byte) & 255, Float4);
    };
    const Float4 a = Corner(0), b = Corner(1), c = Corner(2), d = Corner(3);
    const Float4 top = a + fx * (b - a);
    const Float4 bottom = c + fx * (d - c);
    Store(samples + k, top + fy * (bottom - top));
  }
}

}  // namespace terrace
