// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/patch_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <Eigen/Dense>

#include "odometry/clipping.h"
#include "odometry/float4.h"

namespace terrace {
namespace {

constexpr int kSize = PatchTemplate::kSize;
constexpr int kArea = PatchTemplate::kArea;

/// Unwarped samples around a position; false when they leave the image.
/// @param clipped  whether any of them is
bool SampleUpright(const cv::Mat1b& image, const Eigen::Vector2f& position, float* samples, bool* clipped) {
  const float x = position.x() + PatchTemplate::Offset(0);
  const float y = position.y() + PatchTemplate::Offset(0);
  // One vector is read past the last column.
  if (!(x >= 0.0f && y >= 0.0f && x < static_cast<float>(image.cols - kSize - 4) &&
        y < static_cast<float>(image.rows - kSize - 1)))
    return false;
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix);
  const float fy = y - static_cast<float>(iy);
  Float4 above[kSize / 4];
  Float4 low = LoadBytes(image[iy] + ix);
  Float4 high = low;
  for (int j = 0; j <= kSize; ++j) {
    const std::uint8_t* row = image[iy + j] + ix;
    low[0] = std::min(low[0], static_cast<float>(row[0]));
    high[0] = std::max(high[0], static_cast<float>(row[0]));
    for (int i = 0; i < kSize / 4; ++i) {
      const Float4 a = LoadBytes(row + 4 * i);
      const Float4 b = LoadBytes(row + 4 * i + 1);
      low = b < low ? b : low;
      high = b > high ? b : high;
      const Float4 across = a + fx * (b - a);
      if (j > 0) {
        const Float4 v = above[i] + fy * (across - above[i]);
        std::memcpy(samples + (j - 1) * kSize + 4 * i, &v, sizeof v);
      }
      above[i] = across;
    }
  }
  *clipped = std::min({low[0], low[1], low[2], low[3]}) <= 0.0f ||
             std::max({high[0], high[1], high[2], high[3]}) >= 255.0f;
  return true;
}

}  // namespace

bool Align(const cv::Mat1b& image, const PatchTemplate& patch, const Eigen::Vector2f& start,
           int max_iterations, float max_shift_px, Alignment& result) {
  constexpr float kSettledPx = 0.02f;
  constexpr float kMinGain = 0.2f;
  constexpr float kMaxGain = 5.0f;
  alignas(16) float samples[kArea];
  Eigen::Vector2f position = start;
  Eigen::Vector2f exposure(1.0f, 0.0f);
  bool forgives_clipping = false;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    bool clipped = false;
    if (!SampleUpright(image, position, samples, &clipped)) return false;
    Eigen::Matrix4f inverse_normal = patch.inverse_normal;
    float num_used = kArea;
    if (forgives_clipping || (iteration == 0 && (clipped || patch.clipped))) {
      std::uint8_t clip[kArea]{};
      for (int k = 0; clipped && k < kArea; ++k)
        clip[k] = ClipAt(image, position.x() + PatchTemplate::Offset(k % kSize),
                         position.y() + PatchTemplate::Offset(k / kSize));
      WeightedFit weighted;
      if (iteration == 0) {
        weighted.UseUnclipped(patch, clip);
        forgives_clipping = weighted.Solvable();
        if (forgives_clipping) exposure = weighted.Exposure(patch, samples);
      }
      if (forgives_clipping) {
        weighted.UseUnexplained(patch, clip, samples, exposure[0], exposure[1]);
        if (!weighted.all()) {
          if (!weighted.Solvable()) return false;
          num_used = weighted.num_used;
          inverse_normal = weighted.InverseNormal();
          for (int k = 0; k < kArea; ++k) samples[k] *= weighted.weight[k];
        }
      }
    }
    Float4 u{}, v{}, t{}, one{}, square{};
    for (int i = 0; i < kArea; i += 4) {
      const Float4 s = Load(samples + i);
      u += s * Load(patch.gradient_u + i);
      v += s * Load(patch.gradient_v + i);
      t += s * Load(patch.value + i);
      one += s;
      square += s * s;
    }
    const Eigen::Vector4f right(Sum(u), Sum(v), Sum(t), Sum(one));
    const Eigen::Vector4f fit = inverse_normal * right;
    const float gain = fit[2];
    if (!(gain > kMinGain && gain < kMaxGain)) return false;
    exposure = fit.tail<2>();
    Eigen::Vector2f shift = fit.head<2>() / gain;
    const float length = shift.norm();
    constexpr float kMaxStepPx = 2.0f;  // the gradients say nothing farther away
    if (length > kMaxStepPx) shift *= kMaxStepPx / length;
    position -= shift;
    if (!((position - start).squaredNorm() < max_shift_px * max_shift_px)) return false;

    const float total = Sum(square) - right[3] * right[3] / num_used;
    const float residual = std::max(Sum(square) - fit.dot(right), 0.0f);
    result.position = position;
    result.gain = gain;
    result.agreement = total > 0.0f ? 1.0f - residual / total : 0.0f;
    if (length < kSettledPx) {
      const float variance = (residual / (num_used - 4.0f) + 1.0f / 12.0f) / (gain * gain);
      result.covariance = inverse_normal.topLeftCorner<2, 2>() * variance;
      return true;
    }
  }
  return false;
}

}  // namespace terrace
