// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/patch.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "odometry/clipping.h"
#include "odometry/patch_sampling.h"

namespace terrace {
namespace {

constexpr int kSize = PatchTemplate::kSize;
constexpr int kArea = PatchTemplate::kArea;
/// A template with a border of one sample, for the gradients.
constexpr int kWide = kSize + 2;
static_assert(kSize % 4 == 0);

constexpr SquareOffsets<kWide> kWideOffsets;

}  // namespace

bool ExtractTemplate(const cv::Mat1b& image, const Eigen::Vector2f& centre,
                     const Eigen::Matrix2f& A_image_template, PatchTemplate& patch) {
  const Eigen::Matrix2f& A = A_image_template;
  const float reach = 0.5f * (kWide - 1);
  const Eigen::Vector2f extent = A.cwiseAbs() * Eigen::Vector2f(reach, reach);
  if (!(Inside(image, centre.x() - extent.x(), centre.y() - extent.y()) &&
        Inside(image, centre.x() + extent.x(), centre.y() + extent.y())))
    return false;

  alignas(16) float wide[kWide * kWide];
  Sample(
      image, kWideOffsets,
      [&](const Float4& du, const Float4& dv, Float4& x, Float4& y) {
        x = centre.x() + A(0, 0) * du + A(0, 1) * dv;
        y = centre.y() + A(1, 0) * du + A(1, 1) * dv;
      },
      wide);

  patch.clipped = MayBeClipped(image, centre, extent);
  if (patch.clipped) {
    for (int k = 0; k < kArea; ++k) {
      const Eigen::Vector2f o(PatchTemplate::Offset(k % kSize), PatchTemplate::Offset(k / kSize));
      const Eigen::Vector2f at = centre + A * o;
      patch.clip[k] = ClipAt(image, at.x(), at.y());
    }
  }

  float mean = 0.0f;
  for (int j = 0; j < kSize; ++j) {
    const float* const row = wide + (j + 1) * kWide + 1;
    for (int i = 0; i < kSize; ++i) mean += row[i];
    for (int i = 0; i < kSize; i += 4) {
      const float* const at = row + i;
      Store(patch.gradient_u + j * kSize + i, 0.5f * (Load(at + 1) - Load(at - 1)));
      Store(patch.gradient_v + j * kSize + i, 0.5f * (Load(at + kWide) - Load(at - kWide)));
    }
  }
  mean /= kArea;
  for (int j = 0; j < kSize; ++j)
    for (int i = 0; i < kSize; i += 4)
      Store(patch.value + j * kSize + i, Load(wide + (j + 1) * kWide + i + 1) - mean);

  Float4 uu{}, uv{}, ut{}, u1{}, vv{}, vt{}, v1{}, tt{};
  for (int i = 0; i < kArea; i += 4) {
    const Float4 gu = Load(patch.gradient_u + i);
    const Float4 gv = Load(patch.gradient_v + i);
    const Float4 t = Load(patch.value + i);
    uu += gu * gu;
    uv += gu * gv;
    ut += gu * t;
    u1 += gu;
    vv += gv * gv;
    vt += gv * t;
    v1 += gv;
    tt += t * t;
  }
  const float half_trace = 0.5f * (Sum(uu) + Sum(vv));
  const float half_difference = 0.5f * (Sum(uu) - Sum(vv));
  const float smaller = half_trace - std::sqrt(half_difference * half_difference + Sum(uv) * Sum(uv));
  if (smaller < PatchTemplate::kMinTexture * kArea) return false;

  Eigen::Matrix4f normal;
  normal << Sum(uu), Sum(uv), Sum(ut), Sum(u1), Sum(uv), Sum(vv), Sum(vt), Sum(v1), Sum(ut), Sum(vt), Sum(tt),
      0.0f, Sum(u1), Sum(v1), 0.0f, static_cast<float>(kArea);
  patch.inverse_normal = normal.cast<double>().inverse().cast<float>();
  return patch.inverse_normal.allFinite();
}

void PrefetchTemplate(const cv::Mat1b& image, const Eigen::Vector2f& centre) {
  constexpr int kReach = kWide / 2;
  const int u = std::clamp(static_cast<int>(centre.x()) - kReach, 0, image.cols - 1);
  const int v = std::clamp(static_cast<int>(centre.y()), kReach, std::max(kReach, image.rows - 1 - kReach));
  for (int row = v - kReach; row <= std::min(v + kReach, image.rows - 1); ++row)
    __builtin_prefetch(image[row] + u);
}

float Correlation(const cv::Mat1b& image, const PatchTemplate& patch, int u, int v) {
  if (u < 0 || v < 0 || u + kSize > image.cols || v + kSize > image.rows) return -1.0f;
  Float4 cross{}, one{}, square{}, own{};
  for (int j = 0; j < kSize; ++j) {
    const std::uint8_t* row = image[v + j] + u;
    for (int i = 0; i < kSize; i += 4) {
      const Float4 s = LoadBytes(row + i);
      const Float4 t = Load(patch.value + j * kSize + i);
      cross += s * t;
      one += s;
      square += s * s;
      own += t * t;
    }
  }
  const float variance = Sum(square) - Sum(one) * Sum(one) / kArea;
  return Sum(cross) / std::sqrt(std::max(variance * Sum(own), 1.0f));
}

}  // namespace terrace
