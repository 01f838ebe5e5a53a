// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <tbb/enumerable_thread_specific.h>

#include "core/parallel_for.h"
#include "stereo/aligned_array.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/refinement.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TERRACE_STEREO_REFINEMENT_ONCE_
#define TERRACE_STEREO_REFINEMENT_ONCE_
namespace terrace {

constexpr int kReach = 2;         // of the 5x5 window
constexpr int kImageBorder = 64;  // pixels repeated left and right of the images, which vectors may touch
constexpr int kRowMargin = 32;    // floats before and behind each row, which vectors may touch

/// Of rounding two images to whole grey levels.
constexpr float kRoundingVariance = 0.17f;
/// Measured: error / sigma has its 68 % quantile at one.
constexpr float kSigmaScale = 1.45f;
/// Standard deviation [px] of disparities that no texture supports, before the scale: measured too.
constexpr float kUnsupportedSigma = 0.4f;

/// Sums of the known disparities over five pixels of a row, and their extremes.
struct DisparitySums {
  float *n, *total, *low, *high;
};

/// What the two images say about one row at the disparities given, smoothed.
struct ResidualRow {
  float* disparity;  ///< 0 where unknown
  float* valid;      ///< 1, or 0 where unknown or outside the right image
  float* gradient;   ///< mean of both images', along the row
  float* residual;   ///< left less right
  float* at_edge;    ///< 1 where the window holds other surfaces, else 0
};

/// Sums over five pixels of a row.
struct SumRow {
  float *n, *g, *e, *gg, *ge, *ee;
};

/// What belongs to one row, all arrays with kRowMargin on both sides.
struct RefinementRow {
  const float* given;
  DisparitySums disparities;
  ResidualRow residuals;
  SumRow sums;
};

struct RefineLimits {
  float max_step, max_jump, given_sigma;
  float gain;  ///< of the left image against the right one
};

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using TagF = hn::ScalableTag<float>;
using TagI = hn::RebindToSigned<TagF>;
using VecF = hn::Vec<TagF>;

HWY_INLINE VecF LoadBytes(const std::uint8_t* p) {
  const hn::Rebind<std::uint8_t, TagI> bytes;
  return hn::ConvertTo(TagF(), hn::PromoteTo(TagI(), hn::LoadU(bytes, p)));
}

HWY_INLINE VecF SumOfFive(VecF a, VecF b, VecF c, VecF d, VecF e) {
  return hn::Add(hn::Add(hn::Add(a, b), hn::Add(d, e)), c);
}

void SumsOfRow(const ResidualRow& row, int width, const SumRow& sums) {
  const TagF df;
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    VecF n[5], g[5], e[5];
    for (int i = 0; i < 5; ++i) {
      const int at = u + i - kReach;
      n[i] = hn::LoadU(df, row.valid + at);
      g[i] = hn::LoadU(df, row.gradient + at);
      e[i] = hn::LoadU(df, row.residual + at);
    }
    const auto sum = [&](const VecF* a) HWY_ATTR { return SumOfFive(a[0], a[1], a[2], a[3], a[4]); };
    const auto sum_products = [&](const VecF* a, const VecF* b) HWY_ATTR {
      return SumOfFive(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1]), hn::Mul(a[2], b[2]), hn::Mul(a[3], b[3]),
                       hn::Mul(a[4], b[4]));
    };
    hn::StoreU(sum(n), df, sums.n + u);
    hn::StoreU(sum(g), df, sums.g + u);
    hn::StoreU(sum(e), df, sums.e + u);
    hn::StoreU(sum_products(g, g), df, sums.gg + u);
    hn::StoreU(sum_products(g, e), df, sums.ge + u);
    hn::StoreU(sum_products(e, e), df, sums.ee + u);
  }
}

void DisparitySumsOfRow(const float* disparity, int width, const DisparitySums& sums) {
  const TagF df;
  const auto far_away = hn::Set(df, 1e6f), one = hn::Set(df, 1.0f);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    VecF n[5], d[5];
    auto low = far_away, high = hn::Neg(far_away);
    for (int i = 0; i < 5; ++i) {
      const auto given = hn::LoadU(df, disparity + u + i - kReach);
      const auto known = hn::Eq(given, given);
      n[i] = hn::IfThenElseZero(known, one);
      d[i] = hn::IfThenElseZero(known, given);
      low = hn::Min(low, hn::IfThenElse(known, given, far_away));
      high = hn::Max(high, hn::IfThenElse(known, given, hn::Neg(far_away)));
    }
    hn::StoreU(SumOfFive(n[0], n[1], n[2], n[3], n[4]), df, sums.n + u);
    hn::StoreU(SumOfFive(d[0], d[1], d[2], d[3], d[4]), df, sums.total + u);
    hn::StoreU(low, df, sums.low + u);
    hn::StoreU(high, df, sums.high + u);
  }
}

/// 1 / n of counts; mostly all are those of full windows.
HWY_INLINE VecF Reciprocal(VecF n) {
  const TagF df;
  const auto full = hn::Set(df, 25.0f), one = hn::Set(df, 1.0f);
  if (hn::AllTrue(df, hn::Eq(n, full))) return hn::Set(df, 1.0f / 25.0f);
  return hn::Div(one, hn::Max(n, one));
}

/// For each lane, the mean of the known disparities of the window that belong to the same surface; NaN where
/// unknown.
HWY_INLINE VecF Smooth(const RefinementRow* rows, int u, float max_jump, VecF& at_edge) {
  const TagF df;
  const auto one = hn::Set(df, 1.0f);
  const auto jump = hn::Set(df, max_jump);
  const auto down = [&](float* const DisparitySums::*what) HWY_ATTR {
    const auto of = [&](int r) HWY_ATTR { return hn::LoadU(df, rows[r].disparities.*what + u); };
    return SumOfFive(of(0), of(1), of(2), of(3), of(4));
  };
  auto n = down(&DisparitySums::n), total = down(&DisparitySums::total);
  auto low = hn::LoadU(df, rows[0].disparities.low + u), high = hn::LoadU(df, rows[0].disparities.high + u);
  for (int r = 1; r < 5; ++r) {
    low = hn::Min(low, hn::LoadU(df, rows[r].disparities.low + u));
    high = hn::Max(high, hn::LoadU(df, rows[r].disparities.high + u));
  }
  const auto d = hn::LoadU(df, rows[kReach].given + u);
  const auto edge = hn::Gt(hn::Max(hn::Sub(high, d), hn::Sub(d, low)), jump);  // false where unknown
  at_edge = hn::IfThenElseZero(edge, one);
  if (!hn::AllFalse(df, edge)) {
    auto own_n = hn::Zero(df), own_total = hn::Zero(df);
    for (int r = 0; r < 5; ++r)
      for (int i = 0; i < 5; ++i) {
        const auto other = hn::LoadU(df, rows[r].given + u + i - kReach);
        const auto same = hn::Le(hn::Abs(hn::Sub(other, d)), jump);
        own_n = hn::Add(own_n, hn::IfThenElseZero(same, one));
        own_total = hn::Add(own_total, hn::IfThenElseZero(same, other));
      }
    n = hn::IfThenElse(edge, own_n, n);
    total = hn::IfThenElse(edge, own_total, total);
  }
  return hn::IfThenElse(hn::Eq(d, d), hn::Mul(total, Reciprocal(n)), d);
}

/// The four bytes from `row + offset` on, for each lane. Where neighbours look for neighbours, one load has
/// them all.
HWY_INLINE hn::Vec<TagI> FourPixels(const std::uint8_t* row, hn::Vec<TagI> offset) {
  const TagI di;
  const hn::RebindToUnsigned<TagI> du;
  const int lanes = static_cast<int>(hn::Lanes(di));
  const int begin = hn::GetLane(offset) - lanes;
  const auto place = hn::Sub(offset, hn::Set(di, begin));
  const auto together = hn::And(hn::Gt(place, hn::Set(di, -1)), hn::Lt(place, hn::Set(di, 4 * (lanes - 1))));
  if (!hn::AllTrue(di, together))
    return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(row), offset);
  const auto words = hn::LoadU(du, reinterpret_cast<const std::uint32_t*>(row + begin));
  const auto word = hn::ShiftRight<2>(place);
  const auto bits = hn::BitCast(du, hn::ShiftLeft<3>(hn::And(place, hn::Set(di, 3))));
  const auto low = hn::TableLookupLanes(words, hn::IndicesFromVec(du, word));
  const auto high = hn::TableLookupLanes(words, hn::IndicesFromVec(du, hn::Add(word, hn::Set(di, 1))));
  const auto rest = hn::Shl(hn::ShiftLeft<1>(high), hn::Sub(hn::Set(du, 31), bits));
  return hn::BitCast(di, hn::Or(hn::Shr(low, bits), rest));
}

/// Residual and gradient of the middle one of five rows. The right image is sampled by the cubic of Catmull
/// and Rom, whose slope at whole pixels is the central difference that is taken in the left image.
void ResidualsOfRow(const std::uint8_t* left, const std::uint8_t* right, const RefinementRow* rows, int width,
                    const RefineLimits& limits) {
  const ResidualRow out = rows[kReach].residuals;
  const TagF df;
  const TagI di;
  const auto zero = hn::Zero(df), half = hn::Set(df, 0.5f), one = hn::Set(df, 1.0f);
  const auto v_gain = hn::Set(df, limits.gain);
  const auto last = hn::Set(df, static_cast<float>(width - 1));
  const auto mask_byte = hn::Set(di, 255);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto own = hn::LoadU(df, rows[kReach].given + u);
    if (hn::AllFalse(df, hn::Eq(own, own))) {  // all unknown
      for (float* array : {out.disparity, out.valid, out.gradient, out.residual, out.at_edge})
        hn::StoreU(zero, df, array + u);
      continue;
    }
    VecF at_edge;
    const auto given = Smooth(rows, u, limits.max_jump, at_edge);
    const auto x_given = hn::Sub(hn::ConvertTo(df, hn::Iota(di, u)), given);
    // Comparisons with NaN are false.
    const auto valid = hn::And(hn::Ge(x_given, zero), hn::Le(x_given, last));
    const auto d = hn::IfThenElseZero(valid, given);
    const auto x = hn::IfThenElseZero(valid, x_given);
    const auto whole = hn::ConvertTo(di, x);  // x is not negative
    const auto f = hn::Sub(x, hn::ConvertTo(df, whole));
    const auto four = FourPixels(right - 1, whole);
    const auto p0 = hn::ConvertTo(df, hn::And(four, mask_byte));
    const auto p1 = hn::ConvertTo(df, hn::And(hn::ShiftRight<8>(four), mask_byte));
    const auto p2 = hn::ConvertTo(df, hn::And(hn::ShiftRight<16>(four), mask_byte));
    const auto p3 = hn::ConvertTo(df, hn::And(hn::ShiftRight<24>(four), mask_byte));
    // p1 + f (c1 + f (c2 + f c3))
    const auto c1 = hn::Mul(half, hn::Sub(p2, p0));
    const auto c3 = hn::Add(hn::Mul(hn::Set(df, 1.5f), hn::Sub(p1, p2)), hn::Mul(half, hn::Sub(p3, p0)));
    const auto c2 = hn::Sub(hn::Sub(hn::Sub(p2, p1), c1), c3);
    const auto value = hn::Add(p1, hn::Mul(f, hn::Add(c1, hn::Mul(f, hn::Add(c2, hn::Mul(f, c3))))));
    const auto slope =
        hn::Add(c1, hn::Mul(f, hn::Add(hn::Add(c2, c2), hn::Mul(hn::Set(df, 3.0f), hn::Mul(f, c3)))));
    const auto left_slope = hn::Mul(half, hn::Sub(LoadBytes(left + u + 1), LoadBytes(left + u - 1)));
    const auto gradient = hn::Mul(half, hn::Add(left_slope, hn::Mul(v_gain, slope)));
    const auto residual = hn::Sub(LoadBytes(left + u), hn::Mul(v_gain, value));
    hn::StoreU(d, df, out.disparity + u);
    hn::StoreU(at_edge, df, out.at_edge + u);
    hn::StoreU(hn::IfThenElseZero(valid, one), df, out.valid + u);
    hn::StoreU(hn::IfThenElseZero(valid, gradient), df, out.gradient + u);
    hn::StoreU(hn::IfThenElseZero(valid, residual), df, out.residual + u);
  }
}

/// Sums over a window for each lane.
struct WindowSums {
  VecF n, g, e, gg, ge, ee;
};

/// The window's pixels one by one, those of other surfaces left out.
HWY_INLINE WindowSums SumsOfSurface(const RefinementRow* rows, int u, float max_jump) {
  const TagF df;
  const auto centre = hn::LoadU(df, rows[kReach].residuals.disparity + u);
  const auto jump = hn::Set(df, max_jump);
  WindowSums s = {hn::Zero(df), hn::Zero(df), hn::Zero(df), hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  for (int r = 0; r < 5; ++r)
    for (int i = 0; i < 5; ++i) {
      const int at = u + i - kReach;
      const auto same =
          hn::Le(hn::Abs(hn::Sub(hn::LoadU(df, rows[r].residuals.disparity + at), centre)), jump);
      const auto g = hn::IfThenElseZero(same, hn::LoadU(df, rows[r].residuals.gradient + at));
      const auto e = hn::IfThenElseZero(same, hn::LoadU(df, rows[r].residuals.residual + at));
      s.n = hn::Add(s.n, hn::IfThenElseZero(same, hn::LoadU(df, rows[r].residuals.valid + at)));
      s.g = hn::Add(s.g, g);
      s.e = hn::Add(s.e, e);
      s.gg = hn::Add(s.gg, hn::Mul(g, g));
      s.ge = hn::Add(s.ge, hn::Mul(g, e));
      s.ee = hn::Add(s.ee, hn::Mul(e, e));
    }
  return s;
}

/// The middle one of five rows, whose residuals and sums are known: disparity and, if wanted, sigma out.
void RefineRow(const RefinementRow* rows, int width, const RefineLimits& limits, float* disparity,
               float* sigma) {
  const TagF df;
  const auto zero = hn::Zero(df), one = hn::Set(df, 1.0f);
  const auto v_unknown = hn::Set(df, std::numeric_limits<float>::quiet_NaN());
  const auto max_step = hn::Set(df, limits.max_step);
  const auto two = hn::Set(df, 2.0f);
  const auto given_weight = hn::Set(df, 1.0f / (limits.given_sigma * limits.given_sigma));
  const auto unsupported_weight = hn::Set(df, 1.0f / (kUnsupportedSigma * kUnsupportedSigma));
  const auto sigma_scale = hn::Set(df, kSigmaScale);
  const auto lost_sigma = hn::Set(df, limits.max_step);
  const ResidualRow own_row = rows[kReach].residuals;
  const SumRow sums[5] = {rows[0].sums, rows[1].sums, rows[2].sums, rows[3].sums, rows[4].sums};
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto known = hn::Gt(hn::LoadU(df, own_row.valid + u), zero);
    if (hn::AllFalse(df, known)) {
      hn::StoreU(v_unknown, df, disparity + u);
      if (sigma) hn::StoreU(v_unknown, df, sigma + u);
      continue;
    }
    const auto down = [&](float* const SumRow::*what) HWY_ATTR {
      return SumOfFive(hn::LoadU(df, sums[0].*what + u), hn::LoadU(df, sums[1].*what + u),
                       hn::LoadU(df, sums[2].*what + u), hn::LoadU(df, sums[3].*what + u),
                       hn::LoadU(df, sums[4].*what + u));
    };
    WindowSums s = {down(&SumRow::n),  down(&SumRow::g),  down(&SumRow::e),
                    down(&SumRow::gg), down(&SumRow::ge), down(&SumRow::ee)};
    const auto d = hn::LoadU(df, own_row.disparity + u);
    const auto at_edge = hn::And(known, hn::Gt(hn::LoadU(df, own_row.at_edge + u), zero));
    if (!hn::AllFalse(df, at_edge)) {
      const WindowSums own = SumsOfSurface(rows, u, limits.max_jump);
      s.n = hn::IfThenElse(at_edge, own.n, s.n);
      s.g = hn::IfThenElse(at_edge, own.g, s.g);
      s.e = hn::IfThenElse(at_edge, own.e, s.e);
      s.gg = hn::IfThenElse(at_edge, own.gg, s.gg);
      s.ge = hn::IfThenElse(at_edge, own.ge, s.ge);
      s.ee = hn::IfThenElse(at_edge, own.ee, s.ee);
    }
    // The window's mean brightness difference is not ours to explain.
    const auto inv_n = Reciprocal(s.n);
    const auto gg = hn::Sub(s.gg, hn::Mul(hn::Mul(s.g, s.g), inv_n));
    const auto ge = hn::Sub(s.ge, hn::Mul(hn::Mul(s.g, s.e), inv_n));
    const auto ee = hn::Sub(s.ee, hn::Mul(hn::Mul(s.e, s.e), inv_n));
    // What the best step would leave unexplained is the noise of the images.
    const auto explained = hn::Div(hn::Mul(ge, ge), hn::Max(gg, one));
    const auto variance =
        hn::Add(hn::Div(hn::Max(hn::Sub(ee, explained), zero), hn::Max(hn::Sub(s.n, two), one)),
                hn::Set(df, kRoundingVariance));
    // left(u) - right(u - d) = -gradient * step for a disparity that is too small by step. The disparity
    // given counts as a measurement too, so that noise does not decide where there is no texture.
    const auto information = hn::Add(gg, hn::Mul(variance, given_weight));
    const auto step = hn::Neg(hn::Div(ge, information));
    const auto moves = hn::Le(hn::Abs(step), max_step);
    hn::StoreU(hn::IfThenElse(known, hn::Add(d, hn::IfThenElseZero(moves, step)), v_unknown), df,
               disparity + u);
    if (!sigma) continue;
    const auto v_sigma = hn::IfThenElse(
        moves,
        hn::Mul(sigma_scale, hn::Sqrt(hn::Div(variance, hn::Add(gg, hn::Mul(variance, unsupported_weight))))),
        lost_sigma);
    hn::StoreU(hn::IfThenElse(known, v_sigma, v_unknown), df, sigma + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(DisparitySumsOfRow);
HWY_EXPORT(ResidualsOfRow);
HWY_EXPORT(SumsOfRow);
HWY_EXPORT(RefineRow);

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr int kRowsPerStrip = 40;
constexpr int kRing = 2 * kReach + 1;  // rows whose sums are needed at once

/// How much brighter the left image is, from every eighth row's pixels with a disparity: ratio of their
/// spreads.
float MeasureGain(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& disparity) {
  std::int64_t n = 0, l1 = 0, r1 = 0, l2 = 0, r2 = 0;
  for (int v = 4; v < left.rows; v += 8)
    for (int u = 0; u < left.cols; u += 2) {
      const float x = static_cast<float>(u) - disparity(v, u);
      if (!(x >= 0.0f)) continue;
      const std::int64_t l = left(v, u), r = right(v, std::min(static_cast<int>(x + 0.5f), right.cols - 1));
      if (l == 0 || l == 255 || r == 0 || r == 255) continue;
      ++n, l1 += l, r1 += r, l2 += l * l, r2 += r * r;
    }
  if (n < 100) return 1.0f;
  const double var_l =
      static_cast<double>(l2) - static_cast<double>(l1) * static_cast<double>(l1) / static_cast<double>(n);
  const double var_r =
      static_cast<double>(r2) - static_cast<double>(r1) * static_cast<double>(r1) / static_cast<double>(n);
  if (var_l <= 0 || var_r <= 0) return 1.0f;
  return static_cast<float>(std::clamp(std::sqrt(var_l / var_r), 0.5, 2.0));
}

}  // namespace

/// What one thread holds while it works on a strip: the last kRing rows, and the results of one.
class Refiner::StripRows {
 public:
  void Prepare(int width) {
    if (width == width_) return;
    width_ = width;
    const std::size_t stride = static_cast<std::size_t>((width + 63) / 64 * 64 + 2 * kRowMargin);
    constexpr std::size_t kNumArrays = 15;
    const std::size_t total = (kNumArrays * kRing + 3) * stride;
    float* next = floats_.Reserve(total);
    std::fill(next, next + total, 0.0f);
    const auto take = [&] {
      float* row = next + kRowMargin;
      next += stride;
      return row;
    };
    for (RefinementRow& row : ring_) {
      row.disparities = {take(), take(), take(), take()};
      row.residuals = {take(), take(), take(), take(), take()};
      row.sums = {take(), take(), take(), take(), take(), take()};
    }
    disparity = take();
    sigma = take();
    unknown = take();
    std::fill(unknown - kRowMargin, unknown - kRowMargin + stride, kUnknown);
  }
  RefinementRow& At(int v) { return ring_[(v + 2 * kRing) % kRing]; }
  /// Rows v - kReach to v + kReach.
  std::array<RefinementRow, kRing> Around(int v) {
    return {At(v - 2), At(v - 1), At(v), At(v + 1), At(v + 2)};
  }
  float* disparity = nullptr;
  float* sigma = nullptr;
  float* unknown = nullptr;  ///< a row of unknown disparities

 private:
  int width_ = 0;
  std::array<RefinementRow, kRing> ring_;
  AlignedArray<float> floats_;
};

class Refiner::Scratch {
 public:
  tbb::enumerable_thread_specific<StripRows> rows;
  cv::Mat1b padded_left, padded_right;
  cv::Mat1f given;
};

Refiner::Refiner(const RefinementSettings& settings)
    : settings_(settings), scratch_(std::make_unique<Scratch>()) {}
Refiner::~Refiner() = default;

void Refiner::Refine(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity, cv::Mat1f* sigma) {
  const int height = left.rows;
  cv::copyMakeBorder(left, scratch_->padded_left, 0, 0, kImageBorder, kImageBorder, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, scratch_->padded_right, 0, 0, kImageBorder, kImageBorder, cv::BORDER_REPLICATE);
  if (sigma) sigma->create(left.size());
  const RefineLimits limits = {settings_.max_step_px, settings_.max_jump_px, settings_.given_sigma_px,
                               MeasureGain(left, right, disparity)};
  for (int iteration = 0; iteration < settings_.iterations; ++iteration) {
    cv::copyMakeBorder(disparity, scratch_->given, 0, 0, kRowMargin, kRowMargin, cv::BORDER_CONSTANT,
                       kUnknown);
    const bool last = iteration + 1 == settings_.iterations;
    ParallelFor((height + kRowsPerStrip - 1) / kRowsPerStrip, [&](int strip) {
      const int top = strip * kRowsPerStrip;
      RefineStrip(top, std::min(top + kRowsPerStrip, height), limits, disparity, last ? sigma : nullptr);
    });
  }
}

/// Three steps, each a few rows behind the one before.
void Refiner::RefineStrip(int top, int bottom, const RefineLimits& limits, cv::Mat1f& disparity,
                          cv::Mat1f* sigma) {
  const int width = disparity.cols, height = disparity.rows;
  StripRows& rows = scratch_->rows.local();
  rows.Prepare(width);
  for (int v = top - 2 * kReach; v < bottom + 2 * kReach; ++v) {
    RefinementRow& row = rows.At(v);
    row.given = v >= 0 && v < height ? scratch_->given[v] + kRowMargin : rows.unknown;
    HWY_DYNAMIC_DISPATCH(DisparitySumsOfRow)(row.given, width, row.disparities);

    const int v_residuals = v - kReach;
    if (v_residuals < top - kReach) continue;
    const int v_image = std::clamp(v_residuals, 0, height - 1);
    HWY_DYNAMIC_DISPATCH(ResidualsOfRow)
    (&scratch_->padded_left(v_image, kImageBorder), &scratch_->padded_right(v_image, kImageBorder),
     rows.Around(v_residuals).data(), width, limits);
    const RefinementRow& with_residuals = rows.At(v_residuals);
    HWY_DYNAMIC_DISPATCH(SumsOfRow)(with_residuals.residuals, width, with_residuals.sums);

    const int v_refined = v - 2 * kReach;
    if (v_refined < top) continue;
    HWY_DYNAMIC_DISPATCH(RefineRow)
    (rows.Around(v_refined).data(), width, limits, rows.disparity, sigma ? rows.sigma : nullptr);
    std::memcpy(disparity[v_refined], rows.disparity, sizeof(float) * width);
    if (sigma) std::memcpy((*sigma)[v_refined], rows.sigma, sizeof(float) * width);
  }
}

}  // namespace terrace
#endif  // HWY_ONCE
