// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <Eigen/Dense>

namespace terrace {
namespace {

constexpr int kSize = PatchTemplate::kSize;
constexpr int kArea = PatchTemplate::kArea;
/// Below this the smaller eigenvalue of the gradient matrix, per pixel, tells noise from noise [grey^2].
constexpr float kMinTexture = 0.1f;
/// Samples that must have a say.
constexpr float kMinUsed = kArea / 3.0f;
/// A true grey of 255 or more, of 0 or less.
constexpr std::uint8_t kTooBright = 1;
constexpr std::uint8_t kTooDark = 2;

/// A template with a border of one sample, for the gradients.
constexpr int kWide = kSize + 2;
static_assert(kSize % 4 == 0);

typedef float Float4 __attribute__((vector_size(16)));
typedef std::int32_t Int4 __attribute__((vector_size(16)));
typedef std::uint8_t Byte4 __attribute__((vector_size(4)));
typedef std::uint8_t Byte16 __attribute__((vector_size(16)));

Float4 Load(const float* p) {
  Float4 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
Float4 LoadBytes(const std::uint8_t* p) {
  Byte4 v;
  std::memcpy(&v, p, sizeof v);
  return __builtin_convertvector(v, Float4);
}
void Store(float* p, const Float4& v) { std::memcpy(p, &v, sizeof v); }
float Sum(const Float4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

float Dot(const float* a, const float* b) {
  Float4 sum{};
  for (int i = 0; i < kArea; i += 4) sum += Load(a + i) * Load(b + i);
  return Sum(sum);
}
float Total(const float* a) {
  Float4 sum{};
  for (int i = 0; i < kArea; i += 4) sum += Load(a + i);
  return Sum(sum);
}

/// True when a bilinear sample can be taken at (x, y).
bool Inside(const cv::Mat1b& image, float x, float y) {
  return x >= 0.0f && y >= 0.0f && x < static_cast<float>(image.cols - 1) &&
         y < static_cast<float>(image.rows - 1);
}

std::uint8_t ClipOf(std::uint8_t grey) { return grey == 255 ? kTooBright : grey == 0 ? kTooDark : 0; }
/// The same of a bilinear sample: of all pixels that it is made of.
std::uint8_t ClipAt(const cv::Mat1b& image, float x, float y) {
  const std::uint8_t* row0 = image[static_cast<int>(y)] + static_cast<int>(x);
  const std::uint8_t* row1 = row0 + image.step;
  return ClipOf(row0[0]) | ClipOf(row0[1]) | ClipOf(row1[0]) | ClipOf(row1[1]);
}

/// False when surely no sample within `extent` of a position is clipped.
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

/// Fits an image patch by a template where some samples have no say.
struct WeightedFit {
  alignas(16) float weight[kArea];  ///< 1 or 0
  float num_used = 0.0f;
  Eigen::Matrix4f normal;  ///< of the basis (gradient_u, gradient_v, value, 1)

  /// Only what is clipped in neither.
  void UseUnclipped(const PatchTemplate& patch, const std::uint8_t* clip) {
    for (int k = 0; k < kArea; ++k) weight[k] = (ClipOf(patch, k) | clip[k]) == 0 ? 1.0f : 0.0f;
    Sum(patch);
  }
  /// All but what differs from gain * template + brightness because it is clipped.
  void UseUnexplained(const PatchTemplate& patch, const std::uint8_t* clip, const float* samples, float gain,
                      float brightness) {
    constexpr float kNoise = 8.0f;  // grey; what agrees, agrees, clipped or not
    for (int k = 0; k < kArea; ++k) {
      const float excess = samples[k] - (gain * patch.value[k] + brightness);
      const bool explained =
          (excess > kNoise && ((ClipOf(patch, k) & kTooBright) | (clip[k] & kTooDark)) != 0) ||
          (excess < -kNoise && ((ClipOf(patch, k) & kTooDark) | (clip[k] & kTooBright)) != 0);
      weight[k] = explained ? 0.0f : 1.0f;
    }
    num_used = Total(weight);
    if (!all()) Sum(patch);
  }
  bool all() const { return num_used == static_cast<float>(kArea); }
  bool Solvable() const {
    // The smaller eigenvalue of the gradients' part is at least determinant / trace.
    const float trace = normal(0, 0) + normal(1, 1);
    const float determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(0, 1);
    return num_used >= kMinUsed && determinant >= kMinTexture * kArea * trace;
  }
  Eigen::Matrix4f InverseNormal() const { return normal.cast<double>().inverse().cast<float>(); }
  /// Contrast and brightness of the image against the template.
  Eigen::Vector2f Exposure(const PatchTemplate& patch, const float* samples) const {
    const float* basis[3] = {patch.gradient_u, patch.gradient_v, patch.value};
    Eigen::Vector4f sums;
    alignas(16) float weighted[kArea];
    for (int k = 0; k < kArea; ++k) weighted[k] = weight[k] * samples[k];
    for (int a = 0; a < 3; ++a) sums[a] = Dot(weighted, basis[a]);
    sums[3] = Total(weighted);
    return (InverseNormal() * sums).tail<2>();
  }

 private:
  static std::uint8_t ClipOf(const PatchTemplate& patch, int k) {
    return patch.clipped ? patch.clip[k] : std::uint8_t{0};
  }
  void Sum(const PatchTemplate& patch) {
    const float* basis[3] = {patch.gradient_u, patch.gradient_v, patch.value};
    alignas(16) float weighted[kArea];
    for (int a = 0; a < 3; ++a) {
      for (int k = 0; k < kArea; ++k) weighted[k] = weight[k] * basis[a][k];
      for (int b = a; b < 3; ++b) normal(a, b) = normal(b, a) = Dot(weighted, basis[b]);
      normal(a, 3) = normal(3, a) = Total(weighted);
    }
    num_used = normal(3, 3) = Total(weight);
  }
};

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
constexpr SquareOffsets<kSize> kOffsets;
constexpr SquareOffsets<kWide> kWideOffsets;

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
  if (smaller < kMinTexture * kArea) return false;

  Eigen::Matrix4f normal;
  normal << Sum(uu), Sum(uv), Sum(ut), Sum(u1), Sum(uv), Sum(vv), Sum(vt), Sum(v1), Sum(ut), Sum(vt), Sum(tt),
      0.0f, Sum(u1), Sum(v1), 0.0f, static_cast<float>(kArea);
  patch.inverse_normal = normal.cast<double>().inverse().cast<float>();
  return patch.inverse_normal.allFinite();
}

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
