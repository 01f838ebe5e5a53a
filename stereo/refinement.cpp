// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/refinement.h"

#include <algorithm>
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

constexpr int kReach = 2;        // of the 5x5 window
constexpr int kImageBorder = 8;  // pixels repeated around the images
constexpr int kRowMargin = 64;   // floats before and behind each row, which vectors may touch

/// Of rounding two images to whole grey levels.
constexpr float kRoundingVariance = 0.17f;
/// Measured: error / sigma has its 68 % quantile at one.
constexpr float kSigmaScale = 1.45f;
/// Standard deviation [px] of disparities that no texture supports, before the scale: measured too.
constexpr float kUnsupportedSigma = 0.4f;

/// What the two images say about one row at the disparities given, all rows with kRowMargin on both sides.
struct ResidualRow {
  float* disparity;  ///< 0 where unknown
  float* valid;      ///< 1, or 0 where unknown or outside the right image
  float* gradient;   ///< mean of both images', along the row
  float* residual;   ///< left less right
};

/// Sums over five pixels of a row.
struct SumRow {
  float *n, *g, *e, *gg, *ge, *ee, *low, *high;
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

/// Residual and gradient of one row. The right image is sampled by the cubic of Catmull and Rom, whose slope
/// at whole pixels is the central difference that is taken in the left image.
void ResidualsOfRow(const std::uint8_t* left, const std::uint8_t* right, const float* disparity, int width,
                    float gain, const ResidualRow& out) {
  const TagF df;
  const TagI di;
  const auto zero = hn::Zero(df), half = hn::Set(df, 0.5f), one = hn::Set(df, 1.0f);
  const auto v_gain = hn::Set(df, gain);
  const auto last = hn::Set(df, static_cast<float>(width - 1));
  const auto mask_byte = hn::Set(di, 255);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto given = hn::LoadU(df, disparity + u);
    const auto x_given = hn::Sub(hn::ConvertTo(df, hn::Iota(di, u)), given);
    // Comparisons with NaN are false.
    const auto valid = hn::And(hn::Ge(x_given, zero), hn::Le(x_given, last));
    const auto d = hn::IfThenElseZero(valid, given);
    const auto x = hn::IfThenElseZero(valid, x_given);
    const auto whole = hn::ConvertTo(di, x);  // x is not negative
    const auto f = hn::Sub(x, hn::ConvertTo(df, whole));
    const auto four = hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(right - 1), whole);
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
    hn::StoreU(hn::IfThenElseZero(valid, one), df, out.valid + u);
    hn::StoreU(hn::IfThenElseZero(valid, gradient), df, out.gradient + u);
    hn::StoreU(hn::IfThenElseZero(valid, residual), df, out.residual + u);
  }
}

HWY_INLINE VecF SumOfFive(VecF a, VecF b, VecF c, VecF d, VecF e) {
  return hn::Add(hn::Add(hn::Add(a, b), hn::Add(d, e)), c);
}

void SumsOfRow(const ResidualRow& row, int width, const SumRow& sums) {
  const TagF df;
  const auto far_away = hn::Set(df, 1e6f);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    VecF n[5], g[5], e[5];
    auto low = far_away, high = hn::Neg(far_away);
    for (int i = 0; i < 5; ++i) {
      const int at = u + i - kReach;
      n[i] = hn::LoadU(df, row.valid + at);
      g[i] = hn::LoadU(df, row.gradient + at);
      e[i] = hn::LoadU(df, row.residual + at);
      const auto d = hn::LoadU(df, row.disparity + at);
      const auto known = hn::Gt(n[i], hn::Zero(df));
      low = hn::Min(low, hn::IfThenElse(known, d, far_away));
      high = hn::Max(high, hn::IfThenElse(known, d, hn::Neg(far_away)));
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
    hn::StoreU(low, df, sums.low + u);
    hn::StoreU(high, df, sums.high + u);
  }
}

/// Sums of known disparities over five pixels of a row, with their extremes.
void DisparitySumsOfRow(const float* disparity, int width, const SumRow& sums) {
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
    hn::StoreU(SumOfFive(d[0], d[1], d[2], d[3], d[4]), df, sums.g + u);
    hn::StoreU(low, df, sums.low + u);
    hn::StoreU(high, df, sums.high + u);
  }
}

/// Mean of the known disparities of the window that belong to the same surface; NaN where unknown.
void SmoothRow(const float* const* disparity, const SumRow* sums, int width, float max_jump, float* out) {
  const TagF df;
  const auto one = hn::Set(df, 1.0f);
  const auto jump = hn::Set(df, max_jump);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto down = [&](float* const SumRow::*what) HWY_ATTR {
      return SumOfFive(hn::LoadU(df, sums[0].*what + u), hn::LoadU(df, sums[1].*what + u),
                       hn::LoadU(df, sums[2].*what + u), hn::LoadU(df, sums[3].*what + u),
                       hn::LoadU(df, sums[4].*what + u));
    };
    auto n = down(&SumRow::n), total = down(&SumRow::g);
    auto low = hn::LoadU(df, sums[0].low + u), high = hn::LoadU(df, sums[0].high + u);
    for (int r = 1; r < 5; ++r) {
      low = hn::Min(low, hn::LoadU(df, sums[r].low + u));
      high = hn::Max(high, hn::LoadU(df, sums[r].high + u));
    }
    const auto d = hn::LoadU(df, disparity[kReach] + u);
    const auto at_edge = hn::Gt(hn::Max(hn::Sub(high, d), hn::Sub(d, low)), jump);  // false where unknown
    if (!hn::AllFalse(df, at_edge)) {
      auto own_n = hn::Zero(df), own_total = hn::Zero(df);
      for (int r = 0; r < 5; ++r)
        for (int i = 0; i < 5; ++i) {
          const auto other = hn::LoadU(df, disparity[r] + u + i - kReach);
          const auto same = hn::Le(hn::Abs(hn::Sub(other, d)), jump);
          own_n = hn::Add(own_n, hn::IfThenElseZero(same, one));
          own_total = hn::Add(own_total, hn::IfThenElseZero(same, other));
        }
      n = hn::IfThenElse(at_edge, own_n, n);
      total = hn::IfThenElse(at_edge, own_total, total);
    }
    const auto mean = hn::Div(total, hn::Max(n, one));
    hn::StoreU(hn::IfThenElse(hn::Eq(d, d), mean, d), df, out + u);
  }
}

/// Sums over a window for each lane.
struct WindowSums {
  VecF n, g, e, gg, ge, ee;
};

/// The window's pixels one by one, those of other surfaces left out.
HWY_INLINE WindowSums SumsOfSurface(const ResidualRow* rows, int u, float max_jump) {
  const TagF df;
  const auto centre = hn::LoadU(df, rows[kReach].disparity + u);
  const auto jump = hn::Set(df, max_jump);
  WindowSums s = {hn::Zero(df), hn::Zero(df), hn::Zero(df), hn::Zero(df), hn::Zero(df), hn::Zero(df)};
  for (int r = 0; r < 5; ++r)
    for (int i = 0; i < 5; ++i) {
      const int at = u + i - kReach;
      const auto same = hn::Le(hn::Abs(hn::Sub(hn::LoadU(df, rows[r].disparity + at), centre)), jump);
      const auto g = hn::IfThenElseZero(same, hn::LoadU(df, rows[r].gradient + at));
      const auto e = hn::IfThenElseZero(same, hn::LoadU(df, rows[r].residual + at));
      s.n = hn::Add(s.n, hn::IfThenElseZero(same, hn::LoadU(df, rows[r].valid + at)));
      s.g = hn::Add(s.g, g);
      s.e = hn::Add(s.e, e);
      s.gg = hn::Add(s.gg, hn::Mul(g, g));
      s.ge = hn::Add(s.ge, hn::Mul(g, e));
      s.ee = hn::Add(s.ee, hn::Mul(e, e));
    }
  return s;
}

/// One row: five rows of residuals and sums around it in, disparity and sigma out.
void RefineRow(const ResidualRow* rows, const SumRow* sums, int width, const RefineLimits& limits,
               float* disparity, float* sigma) {
  const TagF df;
  const auto zero = hn::Zero(df), one = hn::Set(df, 1.0f);
  const auto v_unknown = hn::Set(df, std::numeric_limits<float>::quiet_NaN());
  const auto max_step = hn::Set(df, limits.max_step);
  const auto max_jump = hn::Set(df, limits.max_jump);
  const auto two = hn::Set(df, 2.0f);
  const auto given_weight = hn::Set(df, 1.0f / (limits.given_sigma * limits.given_sigma));
  const auto unsupported_weight = hn::Set(df, 1.0f / (kUnsupportedSigma * kUnsupportedSigma));
  const auto sigma_scale = hn::Set(df, kSigmaScale);
  const auto lost_sigma = hn::Set(df, limits.max_step);
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto down = [&](float* const SumRow::*what) HWY_ATTR {
      return SumOfFive(hn::LoadU(df, sums[0].*what + u), hn::LoadU(df, sums[1].*what + u),
                       hn::LoadU(df, sums[2].*what + u), hn::LoadU(df, sums[3].*what + u),
                       hn::LoadU(df, sums[4].*what + u));
    };
    WindowSums s = {down(&SumRow::n),  down(&SumRow::g),  down(&SumRow::e),
                    down(&SumRow::gg), down(&SumRow::ge), down(&SumRow::ee)};
    auto low = hn::LoadU(df, sums[0].low + u), high = hn::LoadU(df, sums[0].high + u);
    for (int r = 1; r < 5; ++r) {
      low = hn::Min(low, hn::LoadU(df, sums[r].low + u));
      high = hn::Max(high, hn::LoadU(df, sums[r].high + u));
    }
    const auto d = hn::LoadU(df, rows[kReach].disparity + u);
    const auto known = hn::Gt(hn::LoadU(df, rows[kReach].valid + u), zero);
    const auto at_edge = hn::And(known, hn::Gt(hn::Max(hn::Sub(high, d), hn::Sub(d, low)), max_jump));
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
    const auto inv_n = hn::Div(one, hn::Max(s.n, one));
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
    const auto v_sigma = hn::IfThenElse(
        moves,
        hn::Mul(sigma_scale, hn::Sqrt(hn::Div(variance, hn::Add(gg, hn::Mul(variance, unsupported_weight))))),
        lost_sigma);
    hn::StoreU(hn::IfThenElse(known, hn::Add(d, hn::IfThenElseZero(moves, step)), v_unknown), df,
               disparity + u);
    hn::StoreU(hn::IfThenElse(known, v_sigma, v_unknown), df, sigma + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(ResidualsOfRow);
HWY_EXPORT(SumsOfRow);
HWY_EXPORT(RefineRow);
HWY_EXPORT(DisparitySumsOfRow);
HWY_EXPORT(SmoothRow);

namespace {

constexpr int kRowsPerStrip = 24;

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

/// Rows of floats of one strip with their margins, which hold zeros (NaN in `given`) from the beginning.
class Refiner::StripRows {
 public:
  void Prepare(int num_rows, int width) {
    if (width == width_ && num_rows <= static_cast<int>(given.size())) return;
    width_ = width;
    const std::size_t stride = static_cast<std::size_t>((width + 63) / 64 * 64 + 2 * kRowMargin);
    constexpr std::size_t kNumArrays = 13;
    const std::size_t total = kNumArrays * stride * num_rows + 2 * stride;
    float* next = floats_.Reserve(total);
    std::fill(next, next + total, 0.0f);
    const auto take = [&] {
      float* row = next + kRowMargin;
      next += stride;
      return row;
    };
    residuals.resize(num_rows);
    sums.resize(num_rows);
    given.resize(num_rows);
    for (int r = 0; r < num_rows; ++r) {
      given[r] = take();
      std::fill(given[r] - kRowMargin, given[r] + stride - kRowMargin,
                std::numeric_limits<float>::quiet_NaN());
      residuals[r] = {take(), take(), take(), take()};
      sums[r] = {take(), take(), take(), take(), take(), take(), take(), take()};
    }
    disparity = take();
    sigma = take();
  }
  std::vector<float*> given;
  std::vector<ResidualRow> residuals;
  std::vector<SumRow> sums;
  float* disparity = nullptr;
  float* sigma = nullptr;

 private:
  int width_ = 0;
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

void Refiner::Refine(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity, cv::Mat1f& sigma) {
  const int width = left.cols, height = left.rows;
  cv::Mat1b& padded_left = scratch_->padded_left;
  cv::Mat1b& padded_right = scratch_->padded_right;
  cv::copyMakeBorder(left, padded_left, 0, 0, kImageBorder, 64, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, padded_right, 0, 0, kImageBorder, 64, cv::BORDER_REPLICATE);
  const RefineLimits limits = {settings_.max_step_px, settings_.max_jump_px, settings_.given_sigma_px,
                               MeasureGain(left, right, disparity)};
  sigma.create(left.size());
  cv::Mat1f& given = scratch_->given;
  for (int iteration = 0; iteration < settings_.iterations; ++iteration) {
    disparity.copyTo(given);
    ParallelFor((height + kRowsPerStrip - 1) / kRowsPerStrip, [&](int strip) {
      StripRows& rows = scratch_->rows.local();
      const int top = strip * kRowsPerStrip, bottom = std::min(top + kRowsPerStrip, height);
      const int num_rows = bottom - top + 4 * kReach;
      rows.Prepare(kRowsPerStrip + 4 * kReach, width);
      // Row r of the scratch is row v = top - 2 kReach + r of the image.
      for (int r = 0; r < num_rows; ++r) {
        const int v = top - 2 * kReach + r;
        if (v >= 0 && v < height)
          std::memcpy(rows.given[r], given[v], sizeof(float) * width);
        else
          std::fill_n(rows.given[r], width, std::numeric_limits<float>::quiet_NaN());
        HWY_DYNAMIC_DISPATCH(DisparitySumsOfRow)(rows.given[r], width, rows.sums[r]);
      }
      for (int r = kReach; r < num_rows - kReach; ++r) {
        const int v = std::clamp(top - 2 * kReach + r, 0, height - 1);
        float* smooth = rows.disparity;
        HWY_DYNAMIC_DISPATCH(SmoothRow)
        (&rows.given[r - kReach], &rows.sums[r - kReach], width, limits.max_jump, smooth);
        HWY_DYNAMIC_DISPATCH(ResidualsOfRow)
        (&padded_left(v, kImageBorder), &padded_right(v, kImageBorder), smooth, width, limits.gain,
         rows.residuals[r]);
      }
      for (int r = kReach; r < num_rows - kReach; ++r)
        HWY_DYNAMIC_DISPATCH(SumsOfRow)(rows.residuals[r], width, rows.sums[r]);
      for (int v = top; v < bottom; ++v) {
        const int first = v - top + kReach;
        HWY_DYNAMIC_DISPATCH(RefineRow)
        (&rows.residuals[first], &rows.sums[first], width, limits, rows.disparity, rows.sigma);
        std::memcpy(disparity[v], rows.disparity, sizeof(float) * width);
        std::memcpy(sigma[v], rows.sigma, sizeof(float) * width);
      }
    });
  }
}

}  // namespace terrace
#endif  // HWY_ONCE
