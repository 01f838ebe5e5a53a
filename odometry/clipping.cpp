// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/clipping.h"

#include <algorithm>
#include <cstring>

#include <Eigen/Dense>

#include "odometry/patch_sampling.h"

namespace terrace {
namespace {

constexpr int kArea = PatchTemplate::kArea;
/// Samples that must have a say.
constexpr float kMinUsed = kArea / 3.0f;

std::uint8_t ClipOfSample(const PatchTemplate& patch, int k) {
  return patch.clipped ? patch.clip[k] : std::uint8_t{0};
}

}  // namespace

std::uint8_t ClipAt(const cv::Mat1b& image, float x, float y) {
  const std::uint8_t* row0 = image[static_cast<int>(y)] + static_cast<int>(x);
  const std::uint8_t* row1 = row0 + image.step;
  return ClipOf(row0[0]) | ClipOf(row0[1]) | ClipOf(row1[0]) | ClipOf(row1[1]);
}

bool MayBeClipped(const cv::Mat1b& image, const Eigen::Vector2f& position, const Eigen::Vector2f& extent) {
  constexpr int kBlock = 16;
  if (image.cols < kBlock) return true;
  const int u1 = static_cast<int>(position.x() + extent.x()) + 1;
  const int v1 = static_cast<int>(position.y() + extent.y()) + 1;
  Byte16 low = Byte16{} + std::uint8_t{255};
  Byte16 high{};
  for (int v = static_cast<int>(position.y() - extent.y()); v <= v1; ++v) {
    for (int u = static_cast<int>(position.x() - extent.x()); u <= u1; u += kBlock) {
      Byte16 greys;
      std::memcpy(&greys, image[v] + std::min(u, image.cols - kBlock), sizeof greys);
      low = greys < low ? greys : low;
      high = greys > high ? greys : high;
    }
  }
  bool clipped = false;
  for (int i = 0; i < kBlock; ++i) clipped = clipped || ClipOf(low[i]) != 0 || ClipOf(high[i]) != 0;
  return clipped;
}

void WeightedFit::UseUnclipped(const PatchTemplate& patch, const std::uint8_t* clip) {
  for (int k = 0; k < kArea; ++k) weight[k] = (ClipOfSample(patch, k) | clip[k]) == 0 ? 1.0f : 0.0f;
  SumUp(patch);
}

void WeightedFit::UseUnexplained(const PatchTemplate& patch, const std::uint8_t* clip, const float* samples,
                                 float gain, float brightness) {
  constexpr float kNoise = 8.0f;  // grey; what agrees, agrees, clipped or not
  for (int k = 0; k < kArea; ++k) {
    const float excess = samples[k] - (gain * patch.value[k] + brightness);
    const bool explained =
        (excess > kNoise && ((ClipOfSample(patch, k) & kTooBright) | (clip[k] & kTooDark)) != 0) ||
        (excess < -kNoise && ((ClipOfSample(patch, k) & kTooDark) | (clip[k] & kTooBright)) != 0);
    weight[k] = explained ? 0.0f : 1.0f;
  }
  num_used = Total(weight);
  if (!all()) SumUp(patch);
}

bool WeightedFit::Solvable() const {
  // The smaller eigenvalue of the gradients' part is at least determinant / trace.
  const float trace = normal(0, 0) + normal(1, 1);
  const float determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(0, 1);
  return num_used >= kMinUsed && determinant >= PatchTemplate::kMinTexture * kArea * trace;
}

Eigen::Matrix4f WeightedFit::InverseNormal() const { return normal.cast<double>().inverse().cast<float>(); }

Eigen::Vector2f WeightedFit::Exposure(const PatchTemplate& patch, const float* samples) const {
  const float* basis[3] = {patch.gradient_u, patch.gradient_v, patch.value};
  Eigen::Vector4f sums;
  alignas(16) float weighted[kArea];
  for (int k = 0; k < kArea; ++k) weighted[k] = weight[k] * samples[k];
  for (int a = 0; a < 3; ++a) sums[a] = Dot(weighted, basis[a]);
  sums[3] = Total(weighted);
  return (InverseNormal() * sums).tail<2>();
}

void WeightedFit::SumUp(const PatchTemplate& patch) {
  const float* basis[3] = {patch.gradient_u, patch.gradient_v, patch.value};
  alignas(16) float weighted[kArea];
  for (int a = 0; a < 3; ++a) {
    for (int k = 0; k < kArea; ++k) weighted[k] = weight[k] * basis[a][k];
    for (int b = a; b < 3; ++b) normal(a, b) = normal(b, a) = Dot(weighted, basis[b]);
    normal(a, 3) = normal(3, a) = Total(weighted);
  }
  num_used = normal(3, 3) = Total(weight);
}

}  // namespace terrace
