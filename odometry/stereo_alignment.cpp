// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/stereo_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "odometry/patch.h"
#include "odometry/patch_sampling.h"

namespace terrace {
namespace {

constexpr int kSize = PatchTemplate::kSize;
constexpr int kArea = PatchTemplate::kArea;
constexpr SquareOffsets<kSize> kOffsets;

}  // namespace

bool AlignStereo(const cv::Mat1b& left, const cv::Mat1b& right, const Eigen::Vector2f& position_left,
                 float vertical_px, StereoAlignment& result) {
  constexpr int kMaxIterations = 12;
  constexpr float kSettledPx = 0.02f;
  constexpr float kMaxMovePx = 4.0f;
  constexpr float kMaxGradient = 0.7f;
  constexpr float kMaxVerticalPx = 3.0f;
  /// How steep surfaces are, before looking: keeps weak texture from inventing a slant.
  constexpr float kGradientPrior = 0.3f;
  using Vector6f = Eigen::Matrix<float, 6, 1>;
  using Matrix6f = Eigen::Matrix<float, 6, 6>;

  PatchTemplate patch;
  if (!ExtractTemplate(left, position_left, Eigen::Matrix2f::Identity(), patch)) return false;

  // Basis: disparity, its gradients along u and v, vertical shift, contrast; and brightness.
  alignas(16) float across[kArea];
  alignas(16) float down[kArea];
  for (int k = 0; k < kArea; ++k) {
    across[k] = PatchTemplate::Offset(k % kSize) * patch.gradient_u[k];
    down[k] = PatchTemplate::Offset(k / kSize) * patch.gradient_u[k];
  }
  const std::array<const float*, 5> basis{patch.gradient_u, across, down, patch.gradient_v, patch.value};
  Matrix6f normal;
  for (int a = 0; a < 5; ++a) {
    for (int b = a; b < 5; ++b) normal(a, b) = normal(b, a) = Dot(basis[a], basis[b]);
    normal(a, 5) = normal(5, a) = Total(basis[a]);
  }
  normal(5, 5) = kArea;

  const float start = result.disparity_px;
  float disparity = start;
  float gradient_u = result.gradient_u;
  float gradient_v = result.gradient_v;
  float vertical = vertical_px;
  float noise_variance = 9.0f;  // grey^2, until there is a residual
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const float extent = 0.5f * (kSize - 1);
    const float y = position_left.y() + vertical;
    const float reach = extent * (1.0f + std::abs(gradient_u) + std::abs(gradient_v));
    const float x = position_left.x() - disparity;
    if (!(Inside(right, x - reach, y - extent) && Inside(right, x + reach, y + extent))) return false;
    alignas(16) float samples[kArea];
    Sample(
        right, kOffsets,
        [&](const Float4& du, const Float4& dv, Float4& u, Float4& v) {
          u = x + du - gradient_u * du - gradient_v * dv;
          v = y + dv;
        },
        samples);
    Vector6f sums;
    for (int a = 0; a < 5; ++a) sums[a] = Dot(basis[a], samples);
    sums[5] = Total(samples);
    const float square = Dot(samples, samples);
    // The slant is drawn towards flat by the prior; its pull acts on the whole slant, not on the step.
    Matrix6f damped = normal;
    Vector6f pulled = sums;
    const float weight = noise_variance / (kGradientPrior * kGradientPrior);
    damped(1, 1) += weight;
    damped(2, 2) += weight;
    pulled[1] -= weight * gradient_u;
    pulled[2] -= weight * gradient_v;
    const Matrix6f inverse = damped.cast<double>().inverse().cast<float>();
    const Vector6f fit = inverse * pulled;
    const float gain = fit[4];
    if (!(gain > 0.3f && gain < 3.0f)) return false;

    // right(x) = left(x + d_true), so reading with d finds left + (d_true - d) * gradient_u.
    const float step = std::clamp(fit[0] / gain, -2.0f, 2.0f);
    disparity += step;
    gradient_u += std::clamp(fit[1] / gain, -0.2f, 0.2f);
    gradient_v += std::clamp(fit[2] / gain, -0.2f, 0.2f);
    vertical -= std::clamp(fit[3] / gain, -1.0f, 1.0f);
    if (!(std::abs(disparity - start) < kMaxMovePx && std::abs(gradient_u) < kMaxGradient &&
          std::abs(gradient_v) < kMaxGradient && std::abs(vertical - vertical_px) < kMaxVerticalPx))
      return false;

    const float total = square - sums[5] * sums[5] / kArea;
    const float residual = std::max(square - 2.0f * fit.dot(sums) + fit.dot(normal * fit), 0.0f);
    noise_variance = residual / (kArea - 6) + 1.0f / 12.0f;
    if (std::abs(step) < kSettledPx) {
      result.disparity_px = disparity;
      result.gradient_u = gradient_u;
      result.gradient_v = gradient_v;
      result.vertical_px = vertical;
      result.agreement = total > 0.0f ? 1.0f - residual / total : 0.0f;
      result.disparity_sigma_px = std::sqrt(noise_variance * inverse(0, 0)) / gain;
      result.gradient_sigma = std::sqrt(noise_variance * std::max(inverse(1, 1), inverse(2, 2))) / gain;
      return disparity > 0.0f;
    }
  }
  return false;
}

}  // namespace terrace
