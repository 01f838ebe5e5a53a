// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/refinement.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
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

constexpr int kReach = 2;  // of the 5x5 window
constexpr int kWindowPixels = 25;
constexpr int kImageBorder = 96;  // pixels repeated left and right of the images, which vectors may touch
constexpr int kRowMargin = UnitImage::kMargin;

constexpr int kUnitsPerPx = UnitImage::kUnitsPerPx;
/// Grey levels and gradients are in eighths, cut so that the sum over a window fits into 16 bits.
constexpr int kGreyUnits = 8;
constexpr int kMaxGrey = 1300;

/// Of rounding two images to whole grey levels.
constexpr float kRoundingVariance = 0.17f * kGreyUnits * kGreyUnits;
/// Measured, as are the next three: the 68 % quantile of error / sigma is about one at every texture.
constexpr float kNoiseScale = 0.76f;
/// How much of the gradients' energy is the images' noise, times its variance.
constexpr float kNoiseInTexture = 2.0f;
/// Standard deviation [px] of disparities that no texture supports, before the scale.
constexpr float kUnsupportedSigma = 1.0f;
/// Standard deviation [px] that no texture goes below: the images are interpolated.
constexpr float kSamplingSigma = 0.045f;

/// The known disparities of five rows, column by column.
struct ColumnDisparities {
  std::int16_t* sum;  ///< without what does not fit into 16 bits
  std::int16_t *low, *high;
};

/// What the two images say about one row at the disparities given, smoothed.
struct ResidualRow {
  std::int16_t* disparity;  ///< 0 where unknown or outside the right image: then all others are 0 as well
  std::int16_t* valid;      ///< 1 where known and not beside another surface
  std::int16_t* gradient;   ///< of the left image, along the row
  std::int16_t* residual;   ///< left less right
  std::int16_t* at_edge;    ///< not 0 where the window holds other surfaces
  std::int16_t* slope;      ///< of the disparity from row to row, where the surface is steep
  bool any_steep = false;   ///< else `slope` holds nothing
};

/// Sums over five rows, column by column. All are whole numbers below 2^24.
struct ColumnSums {
  std::int16_t *n, *g, *e;
  float *gg, *ge, *ee;
};

struct RefineLimits {
  std::int16_t max_jump;  ///< in kUnitsPerPx
  std::int16_t gain;      ///< of the left image against the right one, times 2^13
  float max_step, given_sigma;
};

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag16 = hn::ScalableTag<std::int16_t>;
using Vec16 = hn::Vec<Tag16>;
using TagF = hn::ScalableTag<float>;
using VecF = hn::Vec<TagF>;
using TagI = hn::RebindToSigned<TagF>;
using TagHalf16 = hn::Rebind<std::int16_t, TagF>;

template <class V>
HWY_INLINE V SumOfFive(V a, V b, V c, V d, V e) {
  return hn::Add(hn::Add(hn::Add(a, b), hn::Add(d, e)), c);
}

HWY_INLINE VecF ToFloat(hn::Vec<TagHalf16> v) { return hn::ConvertTo(TagF(), hn::PromoteTo(TagI(), v)); }

/// What the disparity of a row, some rows below the middle one, would be in the middle one's on a surface of
/// that slope: at least 1 where known.
template <class D>
HWY_INLINE hn::Vec<D> AlongSlope(D d, hn::Vec<D> disparity, hn::Vec<D> slope, int rows_below) {
  const auto change = hn::Mul(slope, hn::Set(d, static_cast<std::int16_t>(rows_below)));
  const auto moved = hn::Max(hn::SaturatedSub(disparity, change), hn::Set(d, 1));
  return hn::IfThenElseZero(hn::Gt(disparity, hn::Zero(d)), moved);
}

/// Disparities of steep surfaces are found the less well the steeper they are.
template <class D>
HWY_INLINE hn::Vec<D> JumpOnSlope(D d, std::int16_t max_jump, hn::Vec<D> slope) {
  return hn::Add(hn::Set(d, max_jump), hn::ShiftRight<1>(hn::Abs(slope)));
}

/// @tparam kSteep  slopes are given; else they are all 0
template <bool kSteep>
void DisparitiesOfColumnsWith(const std::int16_t* const* rows, const std::int16_t* slopes, int width,
                              const ColumnDisparities& columns) {
  const Tag16 d;
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(d))) {
    const auto load = [&](int r) HWY_ATTR {
      const auto disparity = hn::LoadU(d, rows[r] + u);
      if constexpr (!kSteep) return disparity;
      return AlongSlope(d, disparity, hn::LoadU(d, slopes + u), r - kReach);
    };
    const auto a = load(0);
    auto sum = a, low = a, high = a;
    for (int r = 1; r < 5; ++r) {
      const auto b = load(r);
      sum = hn::Add(sum, b);
      low = hn::Min(low, b);
      high = hn::Max(high, b);
    }
    hn::StoreU(sum, d, columns.sum + u);
    hn::StoreU(low, d, columns.low + u);
    hn::StoreU(high, d, columns.high + u);
  }
}

void DisparitiesOfColumns(const std::int16_t* const* rows, const ResidualRow& middle, int width,
                          const ColumnDisparities& columns) {
  if (middle.any_steep)
    DisparitiesOfColumnsWith<true>(rows, middle.slope, width, columns);
  else
    DisparitiesOfColumnsWith<false>(rows, nullptr, width, columns);
}

/// sums / counts, rounded.
HWY_INLINE Vec16 Quotient(Vec16 sums, Vec16 counts) {
  const TagF df;
  const TagHalf16 d16;
  const auto shift = hn::Set(df, 4096.5f);  // positive, where conversion rounds down
  const auto divide = [&](hn::Vec<TagHalf16> sum, hn::Vec<TagHalf16> count) HWY_ATTR {
    const auto quotient = hn::Div(ToFloat(sum), hn::Max(ToFloat(count), hn::Set(df, 1.0f)));
    const auto whole = hn::ConvertTo(TagI(), hn::Add(quotient, shift));
    return hn::DemoteTo(d16, hn::Sub(whole, hn::Set(TagI(), 4096)));
  };
  return hn::Combine(Tag16(), divide(hn::UpperHalf(d16, sums), hn::UpperHalf(d16, counts)),
                     divide(hn::LowerHalf(d16, sums), hn::LowerHalf(d16, counts)));
}

/// For each lane, the mean of the known disparities of the window that belong to the same surface; 0 where
/// unknown.
/// @param beside  out: the pixel to the left or to the right does not belong to the same surface
template <bool kSteep>
HWY_INLINE Vec16 Smooth(const std::int16_t* const* rows, const ColumnDisparities& columns,
                        const std::int16_t* slopes, int u, std::int16_t max_jump, Vec16& at_edge,
                        hn::Mask<Tag16>& beside) {
  const Tag16 d;
  const auto zero = hn::Zero(d);
  const auto jump = kSteep ? JumpOnSlope(d, max_jump, hn::LoadU(d, slopes + u)) : hn::Set(d, max_jump);
  const auto own = hn::LoadU(d, rows[kReach] + u);
  auto total = hn::LoadU(d, columns.sum + u - kReach);
  auto low = hn::LoadU(d, columns.low + u - kReach), high = hn::LoadU(d, columns.high + u - kReach);
  for (int i = 1 - kReach; i <= kReach; ++i) {
    total = hn::Add(total, hn::LoadU(d, columns.sum + u + i));
    low = hn::Min(low, hn::LoadU(d, columns.low + u + i));
    high = hn::Max(high, hn::LoadU(d, columns.high + u + i));
  }
  // Differences from the own disparity are small on one surface: their sum fits into 16 bits though that of
  // the disparities does not.
  const auto differences = hn::Sub(total, hn::Mul(own, hn::Set(d, kWindowPixels)));
  auto mean = hn::MulFixedPoint15(differences, hn::Set(d, 32768 / kWindowPixels + 1));
  const auto known = hn::Gt(own, zero);
  const auto several = hn::Or(hn::Gt(hn::Sub(high, own), jump), hn::Gt(hn::Sub(own, low), jump));
  const auto apart = hn::And(known, hn::Or(several, hn::Eq(low, zero)));
  at_edge = zero;
  beside = hn::MaskFromVec(zero);
  if (!hn::AllFalse(d, apart)) {
    const auto other_surface = [&](const std::int16_t* p) HWY_ATTR {
      return hn::Gt(hn::Abs(hn::Sub(hn::LoadU(d, p), own)), jump);
    };
    beside = hn::Or(other_surface(rows[kReach] + u - 1), other_surface(rows[kReach] + u + 1));
    const auto one = hn::Set(d, 1);
    auto num_known = zero, num_own = zero, own_total = zero;
    for (int r = 0; r < 5; ++r)
      for (int i = -kReach; i <= kReach; ++i) {
        auto other = hn::LoadU(d, rows[r] + u + i);
        if constexpr (kSteep) other = AlongSlope(d, other, hn::LoadU(d, slopes + u), r - kReach);
        const auto difference = hn::Sub(other, own);
        const auto other_known = hn::Gt(other, zero);
        const auto same = hn::AndNot(hn::Gt(hn::Abs(difference), jump), other_known);
        num_known = hn::Add(num_known, hn::IfThenElseZero(other_known, one));
        num_own = hn::Add(num_own, hn::IfThenElseZero(same, one));
        own_total = hn::Add(own_total, hn::IfThenElseZero(same, difference));
      }
    mean = hn::IfThenElse(apart, Quotient(own_total, num_own), mean);
    at_edge = hn::IfThenElseZero(apart, hn::Sub(num_known, num_own));
  }
  return hn::IfThenElseZero(known, hn::Max(hn::Add(own, mean), hn::Set(d, 1)));
}

/// Residual and gradient of the middle one of five rows. The right image is sampled by the cubic of Catmull
/// and Rom. The gradient is the left image's alone: between whole pixels the right one's noise is smoothed,
/// and a gradient with a share of it pulls disparities there.
template <bool kSteep>
void ResidualsOfRowWith(const std::uint8_t* left, const std::uint8_t* right, const std::int16_t* const* rows,
                        const ColumnDisparities& columns, int width, const RefineLimits& limits,
                        const ResidualRow& out) {
  const Tag16 d;
  const hn::Rebind<std::uint8_t, Tag16> d8;
  constexpr int kUnitBits = 7;
  static_assert(1 << kUnitBits == kUnitsPerPx);
  const auto zero = hn::Zero(d);
  const auto gain = hn::Set(d, limits.gain);
  const auto most = hn::Set(d, kMaxGrey), least = hn::Set(d, -kMaxGrey);
  const auto pixels = [&](const std::uint8_t* p) HWY_ATTR { return hn::PromoteTo(d, hn::LoadU(d8, p)); };
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(d))) {
    const auto own = hn::LoadU(d, rows[kReach] + u);
    if (hn::AllTrue(d, hn::Eq(own, zero))) {  // all unknown
      for (std::int16_t* array : {out.disparity, out.valid, out.gradient, out.residual, out.at_edge})
        hn::StoreU(zero, d, array + u);
      continue;
    }
    Vec16 at_edge;
    hn::Mask<Tag16> beside;
    const auto given = Smooth<kSteep>(rows, columns, out.slope, u, limits.max_jump, at_edge, beside);
    // u - given = u - whole + fraction, the fraction not negative.
    const auto whole = hn::ShiftRight<kUnitBits>(hn::Add(given, hn::Set(d, kUnitsPerPx - 1)));
    const auto fraction = hn::Sub(hn::ShiftLeft<kUnitBits>(whole), given);
    const auto column = hn::Iota(d, static_cast<std::int16_t>(u));
    const auto valid = hn::And(hn::Gt(given, zero), hn::Gt(hn::Add(column, hn::Set(d, 1)), whole));
    // The four pixels around each place: neighbours of equal whole disparity are neighbours there as well.
    const auto whole8 = hn::DemoteTo(d8, hn::IfThenElseZero(valid, whole));
    auto q0 = hn::Zero(d8), q1 = q0, q2 = q0, q3 = q0;
    HWY_ALIGN std::uint8_t distances[hn::MaxLanes(d8)];
    hn::Store(whole8, d8, distances);
    std::uint64_t rest = ~std::uint64_t{0} >> (64 - hn::Lanes(d8));
    while (rest != 0) {
      const std::uint8_t distance = distances[std::countr_zero(rest)];
      const auto here = hn::Eq(whole8, hn::Set(d8, distance));
      const std::uint8_t* first = right + u - distance - 1;
      q0 = hn::IfThenElse(here, hn::LoadU(d8, first), q0);
      q1 = hn::IfThenElse(here, hn::LoadU(d8, first + 1), q1);
      q2 = hn::IfThenElse(here, hn::LoadU(d8, first + 2), q2);
      q3 = hn::IfThenElse(here, hn::LoadU(d8, first + 3), q3);
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(d8, here, bytes);
      std::uint64_t done;
      std::memcpy(&done, bytes, 8);
      rest &= ~done;
    }
    const auto p0 = hn::PromoteTo(d, q0), p1 = hn::PromoteTo(d, q1);
    const auto p2 = hn::PromoteTo(d, q2), p3 = hn::PromoteTo(d, q3);
    // p1 + f (c1 + f (c2 + f c3)), in sixteenths of a grey level.
    const auto f = hn::ShiftLeft<15 - kUnitBits>(fraction);
    const auto p20 = hn::Sub(p2, p0), p12 = hn::Sub(p1, p2);
    const auto c1 = hn::ShiftLeft<3>(p20);
    const auto c3 = hn::ShiftLeft<3>(hn::Sub(hn::Add(hn::Add(p12, p12), hn::Sub(p3, p2)), hn::Sub(p0, p1)));
    const auto c2 = hn::Sub(hn::Sub(hn::ShiftLeft<4>(hn::Neg(p12)), c1), c3);
    const auto m1 = hn::MulFixedPoint15(f, c3);
    const auto m2 = hn::MulFixedPoint15(f, hn::Add(c2, m1));
    const auto value = hn::Add(hn::ShiftLeft<4>(p1), hn::MulFixedPoint15(f, hn::Add(c1, m2)));
    // In kGreyUnits from here on.
    const auto gradient = hn::ShiftLeft<2>(hn::Sub(pixels(left + u + 1), pixels(left + u - 1)));
    const auto with_gain = hn::MulFixedPoint15(hn::Add(value, value), gain);
    const auto residual = hn::Sub(hn::ShiftLeft<3>(pixels(left + u)), with_gain);
    // Beside another surface, gradient and interpolation mix the two.
    const auto counts = hn::AndNot(beside, valid);
    const auto cut = [&](Vec16 v)
                         HWY_ATTR { return hn::IfThenElseZero(counts, hn::Max(hn::Min(v, most), least)); };
    hn::StoreU(hn::IfThenElseZero(valid, given), d, out.disparity + u);
    hn::StoreU(hn::IfThenElseZero(counts, hn::Set(d, 1)), d, out.valid + u);
    hn::StoreU(cut(gradient), d, out.gradient + u);
    hn::StoreU(cut(residual), d, out.residual + u);
    hn::StoreU(hn::IfThenElseZero(valid, at_edge), d, out.at_edge + u);
  }
}

void ResidualsOfRow(const std::uint8_t* left, const std::uint8_t* right, const std::int16_t* const* rows,
                    const ColumnDisparities& columns, int width, const RefineLimits& limits,
                    const ResidualRow& out) {
  if (out.any_steep)
    ResidualsOfRowWith<true>(left, right, rows, columns, width, limits, out);
  else
    ResidualsOfRowWith<false>(left, right, rows, columns, width, limits, out);
}

/// Moves the sums of columns down by a row.
void MoveColumnSums(const ResidualRow& entering, const ResidualRow& leaving, int width,
                    const ColumnSums& sums) {
  const Tag16 d;
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(d))) {
    const auto move = [&](const std::int16_t* in, const std::int16_t* gone, std::int16_t* sum) HWY_ATTR {
      const auto change = hn::Sub(hn::LoadU(d, in + u), hn::LoadU(d, gone + u));
      hn::StoreU(hn::Add(hn::LoadU(d, sum + u), change), d, sum + u);
    };
    move(entering.valid, leaving.valid, sums.n);
    move(entering.gradient, leaving.gradient, sums.g);
    move(entering.residual, leaving.residual, sums.e);
  }
  const TagF df;
  const TagHalf16 d16;
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto g_in = ToFloat(hn::LoadU(d16, entering.gradient + u));
    const auto e_in = ToFloat(hn::LoadU(d16, entering.residual + u));
    const auto g_gone = ToFloat(hn::LoadU(d16, leaving.gradient + u));
    const auto e_gone = ToFloat(hn::LoadU(d16, leaving.residual + u));
    const auto move = [&](VecF in, VecF gone, float* sum) HWY_ATTR {
      hn::StoreU(hn::Add(hn::LoadU(df, sum + u), hn::Sub(in, gone)), df, sum + u);
    };
    move(hn::Mul(g_in, g_in), hn::Mul(g_gone, g_gone), sums.gg);
    move(hn::Mul(g_in, e_in), hn::Mul(g_gone, e_gone), sums.ge);
    move(hn::Mul(e_in, e_in), hn::Mul(e_gone, e_gone), sums.ee);
  }
}

/// Sums over a window for each lane.
struct WindowSums {
  VecF n, g, e, gg, ge, ee;
};

/// The window's pixels one by one, those of other surfaces left out.
HWY_INLINE WindowSums SumsOfSurface(const ResidualRow* rows, int u, std::int16_t max_jump) {
  const TagF df;
  const TagHalf16 d16;
  const bool steep = rows[kReach].any_steep;
  const auto slope = steep ? hn::LoadU(d16, rows[kReach].slope + u) : hn::Zero(d16);
  const auto centre = hn::LoadU(d16, rows[kReach].disparity + u);
  const auto jump = steep ? JumpOnSlope(d16, max_jump, slope) : hn::Set(d16, max_jump);
  auto n = hn::Zero(d16), sum_g = n, sum_e = n;
  WindowSums s;
  s.gg = s.ge = s.ee = hn::Zero(df);
  for (int r = 0; r < 5; ++r) {
    VecF gg[5], ge[5], ee[5];
    for (int i = 0; i < 5; ++i) {
      const int at = u + i - kReach;
      auto other = hn::LoadU(d16, rows[r].disparity + at);
      if (steep) other = AlongSlope(d16, other, slope, r - kReach);
      const auto same =
          hn::AndNot(hn::Gt(hn::Abs(hn::Sub(other, centre)), jump), hn::Gt(other, hn::Zero(d16)));
      const auto g = hn::IfThenElseZero(same, hn::LoadU(d16, rows[r].gradient + at));
      const auto e = hn::IfThenElseZero(same, hn::LoadU(d16, rows[r].residual + at));
      n = hn::Add(n, hn::IfThenElseZero(same, hn::LoadU(d16, rows[r].valid + at)));
      sum_g = hn::Add(sum_g, g);
      sum_e = hn::Add(sum_e, e);
      const auto gf = ToFloat(g), ef = ToFloat(e);
      gg[i] = hn::Mul(gf, gf);
      ge[i] = hn::Mul(gf, ef);
      ee[i] = hn::Mul(ef, ef);
    }
    // Row by row, so that one addition need not wait for all that went before.
    s.gg = hn::Add(s.gg, SumOfFive(gg[0], gg[1], gg[2], gg[3], gg[4]));
    s.ge = hn::Add(s.ge, SumOfFive(ge[0], ge[1], ge[2], ge[3], ge[4]));
    s.ee = hn::Add(s.ee, SumOfFive(ee[0], ee[1], ee[2], ee[3], ee[4]));
  }
  s.n = ToFloat(n), s.g = ToFloat(sum_g), s.e = ToFloat(sum_e);
  return s;
}

/// 1 / x for x > 0 to 1e-5, by Newton's method from what the bits of x say. The same on every target, and
/// faster than a division.
HWY_INLINE VecF Reciprocal(VecF x) {
  const TagF df;
  const TagI di;
  const auto two = hn::Set(df, 2.0f);
  auto y = hn::BitCast(df, hn::Sub(hn::Set(di, 0x7EF127EA), hn::BitCast(di, x)));
  y = hn::Mul(y, hn::Sub(two, hn::Mul(x, y)));
  return hn::Mul(y, hn::Sub(two, hn::Mul(x, y)));
}

/// 1 / sqrt(x) for x > 0 in the same way.
HWY_INLINE VecF ReciprocalSqrt(VecF x) {
  const TagF df;
  const TagI di;
  const auto half_x = hn::Mul(hn::Set(df, 0.5f), x), three_halves = hn::Set(df, 1.5f);
  auto y = hn::BitCast(df, hn::Sub(hn::Set(di, 0x5F375A86), hn::ShiftRight<1>(hn::BitCast(di, x))));
  y = hn::Mul(y, hn::Sub(three_halves, hn::Mul(half_x, hn::Mul(y, y))));
  return hn::Mul(y, hn::Sub(three_halves, hn::Mul(half_x, hn::Mul(y, y))));
}

/// The middle one of five rows, whose residuals and sums are known: disparity and, if wanted, sigma out.
void RefineRow(const ResidualRow* rows, const ColumnSums& columns, int width, const RefineLimits& limits,
               float* disparity, float* sigma) {
  const TagF df;
  const TagHalf16 d16;
  const auto zero = hn::Zero(df), one = hn::Set(df, 1.0f), two = hn::Set(df, 2.0f);
  const auto full = hn::Set(df, kWindowPixels);
  const auto unknown = hn::Set(df, std::numeric_limits<float>::quiet_NaN());
  const auto px_per_unit = hn::Set(df, 1.0f / kUnitsPerPx);
  const auto max_step = hn::Set(df, limits.max_step);
  const auto given_weight = hn::Set(df, 1.0f / (limits.given_sigma * limits.given_sigma));
  const auto unsupported_weight = hn::Set(df, 1.0f / (kUnsupportedSigma * kUnsupportedSigma));
  const auto noise_scale = hn::Set(df, kNoiseScale * kNoiseScale);
  const auto noise_in_texture = hn::Set(df, kNoiseInTexture);
  const auto of_sampling = hn::Set(df, kSamplingSigma * kSamplingSigma);
  const auto least_gg = hn::Set(df, kGreyUnits * kGreyUnits);
  const auto rounding = hn::Set(df, kRoundingVariance);
  const ResidualRow& own = rows[kReach];
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(df))) {
    const auto units = hn::LoadU(d16, own.disparity + u);
    const auto d = hn::Mul(ToFloat(units), px_per_unit);
    const auto known = hn::Gt(d, zero);
    if (hn::AllFalse(df, known)) {
      hn::StoreU(unknown, df, disparity + u);
      if (sigma) hn::StoreU(unknown, df, sigma + u);
      continue;
    }
    const auto across = [&](auto tag, const auto* sums) HWY_ATTR {
      return SumOfFive(hn::LoadU(tag, sums + u - 2), hn::LoadU(tag, sums + u - 1), hn::LoadU(tag, sums + u),
                       hn::LoadU(tag, sums + u + 1), hn::LoadU(tag, sums + u + 2));
    };
    WindowSums s = {ToFloat(across(d16, columns.n)), ToFloat(across(d16, columns.g)),
                    ToFloat(across(d16, columns.e)), across(df, columns.gg),
                    across(df, columns.ge),          across(df, columns.ee)};
    const auto at_edge = hn::LoadU(d16, own.at_edge + u);
    if (!hn::AllTrue(d16, hn::Eq(at_edge, hn::Zero(d16)))) {
      const auto edge = hn::Gt(ToFloat(at_edge), zero);
      const WindowSums same = SumsOfSurface(rows, u, limits.max_jump);
      s.n = hn::IfThenElse(edge, same.n, s.n);
      s.g = hn::IfThenElse(edge, same.g, s.g);
      s.e = hn::IfThenElse(edge, same.e, s.e);
      s.gg = hn::IfThenElse(edge, same.gg, s.gg);
      s.ge = hn::IfThenElse(edge, same.ge, s.ge);
      s.ee = hn::IfThenElse(edge, same.ee, s.ee);
    }
    // Mostly all windows are full.
    auto inv_n = hn::Set(df, 1.0f / kWindowPixels), inv_freedom = hn::Set(df, 1.0f / (kWindowPixels - 2));
    const auto is_full = hn::Eq(s.n, full);
    if (!hn::AllTrue(df, is_full)) {
      inv_n = hn::IfThenElse(is_full, inv_n, Reciprocal(hn::Max(s.n, one)));
      inv_freedom = hn::IfThenElse(is_full, inv_freedom, Reciprocal(hn::Max(hn::Sub(s.n, two), one)));
    }
    // The window's mean brightness difference is not ours to explain.
    const auto mean_g = hn::Mul(s.g, inv_n);
    const auto gg = hn::Max(hn::Sub(s.gg, hn::Mul(s.g, mean_g)), zero);
    const auto ge = hn::Sub(s.ge, hn::Mul(s.e, mean_g));
    const auto ee = hn::Sub(s.ee, hn::Mul(s.e, hn::Mul(s.e, inv_n)));
    // What the best step would leave unexplained is the noise of the images.
    const auto explained = hn::Mul(hn::Mul(ge, ge), Reciprocal(hn::Max(gg, least_gg)));
    const auto variance = hn::Add(hn::Mul(hn::Max(hn::Sub(ee, explained), zero), inv_freedom), rounding);
    // left(u) - right(u - d) = -gradient * step for a disparity that is too small by step. The disparity
    // given counts as a measurement too, so that noise does not decide where there is no texture.
    const auto step = hn::Neg(hn::Mul(ge, Reciprocal(hn::Add(gg, hn::Mul(variance, given_weight)))));
    const auto moves = hn::Le(hn::Abs(step), max_step);
    hn::StoreU(hn::IfThenElse(known, hn::Add(d, hn::IfThenElseZero(moves, step)), unknown), df,
               disparity + u);
    if (!sigma) continue;
    const auto texture = hn::Max(hn::Sub(gg, hn::Mul(variance, noise_in_texture)), zero);
    const auto information = hn::Add(texture, hn::Mul(variance, unsupported_weight));
    const auto of_noise = hn::Mul(noise_scale, hn::Mul(variance, Reciprocal(information)));
    const auto square = hn::Add(of_noise, of_sampling);
    const auto supported = hn::Mul(square, ReciprocalSqrt(square));
    const auto v_sigma = hn::IfThenElse(moves, supported, max_step);
    hn::StoreU(hn::IfThenElse(known, v_sigma, unknown), df, sigma + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(DisparitiesOfColumns);
HWY_EXPORT(ResidualsOfRow);
HWY_EXPORT(MoveColumnSums);
HWY_EXPORT(RefineRow);

namespace {

constexpr int kRowsPerStrip = 60;
constexpr int kWholeVectors = 64;      // floats: a multiple of every target's vectors
constexpr int kRing = 2 * kReach + 2;  // rows needed at once: those of a window, and the one that leaves it

/// How much brighter the left image is, from every eighth row's pixels with a disparity: ratio of their
/// spreads.
float MeasureGain(const cv::Mat1b& left, const cv::Mat1b& right, const UnitImage& units) {
  std::int64_t n = 0, l1 = 0, r1 = 0, l2 = 0, r2 = 0;
  for (int v = 4; v < left.rows; v += 8) {
    const std::int16_t* disparity = units.Row(v);
    for (int u = 0; u < left.cols; u += 2) {
      const int x = (u * kUnitsPerPx - disparity[u] + kUnitsPerPx / 2) / kUnitsPerPx;
      if (disparity[u] == 0 || x < 0) continue;
      const std::int64_t l = left(v, u), r = right(v, std::min(x, right.cols - 1));
      if (l == 0 || l == 255 || r == 0 || r == 255) continue;
      ++n, l1 += l, r1 += r, l2 += l * l, r2 += r * r;
    }
  }
  if (n < 100) return 1.0f;
  const double var_l =
      static_cast<double>(l2) - static_cast<double>(l1) * static_cast<double>(l1) / static_cast<double>(n);
  const double var_r =
      static_cast<double>(r2) - static_cast<double>(r1) * static_cast<double>(r1) / static_cast<double>(n);
  if (var_l <= 0 || var_r <= 0) return 1.0f;
  return static_cast<float>(std::clamp(std::sqrt(var_l / var_r), 0.5, 2.0));
}

std::size_t Padded(int width) { return static_cast<std::size_t>((width + 63) / 64 * 64); }

}  // namespace

/// What one thread holds while it works on a strip: the residuals of the last kRing rows, sums of their
/// columns, and the results of one row.
class Refiner::StripRows {
 public:
  void Prepare(int width) {
    const std::size_t stride = Padded(width) + 2 * kRowMargin;
    constexpr std::size_t kNumResiduals = 6;
    constexpr std::size_t kNumShorts = 3 + kNumResiduals * kRing + 3;
    if (width != width_) {
      width_ = width;
      std::int16_t* next = shorts_.Reserve(kNumShorts * stride);
      const auto take_shorts = [&] { return std::exchange(next, next + stride) + kRowMargin; };
      float* next_float = floats_.Reserve(5 * stride);
      const auto take_floats = [&] { return std::exchange(next_float, next_float + stride) + kRowMargin; };
      columns = {take_shorts(), take_shorts(), take_shorts()};
      for (ResidualRow& row : ring_)
        row = {take_shorts(), take_shorts(), take_shorts(), take_shorts(), take_shorts(), take_shorts()};
      sums = {take_shorts(), take_shorts(), take_shorts(), take_floats(), take_floats(), take_floats()};
      disparity = take_floats();
      sigma = take_floats();
    }
    // No row has entered the sums yet.
    std::fill_n(shorts_.data(), kNumShorts * stride, std::int16_t{0});
    std::fill_n(floats_.data(), 5 * stride, 0.0f);
    for (ResidualRow& row : ring_) row.any_steep = false;
  }
  ResidualRow& At(int v) { return ring_[(v + 2 * kRing) % kRing]; }
  /// Rows v - kReach to v + kReach.
  std::array<ResidualRow, 2 * kReach + 1> Around(int v) {
    return {At(v - 2), At(v - 1), At(v), At(v + 1), At(v + 2)};
  }
  ColumnDisparities columns;
  ColumnSums sums;
  float* disparity = nullptr;
  float* sigma = nullptr;

 private:
  int width_ = 0;
  std::array<ResidualRow, kRing> ring_;
  AlignedArray<std::int16_t> shorts_;
  AlignedArray<float> floats_;
};

class Refiner::Scratch {
 public:
  tbb::enumerable_thread_specific<StripRows> rows;
  cv::Mat1b padded_left, padded_right;
  UnitImage given, refined;
  std::vector<std::int16_t> unknown;  ///< a row outside the image
};

Refiner::Refiner(const RefinementSettings& settings)
    : settings_(settings), scratch_(std::make_unique<Scratch>()) {}
Refiner::~Refiner() = default;

void Refiner::Refine(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity, cv::Mat1f* sigma,
                     const Steepness& steepness) {
  scratch_->given.Set(disparity);
  Refine(left, right, scratch_->given, disparity, sigma, steepness);
}

void Refiner::Refine(const cv::Mat1b& left, const cv::Mat1b& right, UnitImage& given, cv::Mat1f& disparity,
                     cv::Mat1f* sigma, const Steepness& steepness) {
  const int height = left.rows;
  const int num_strips = (height + kRowsPerStrip - 1) / kRowsPerStrip;
  Scratch& scratch = *scratch_;
  cv::copyMakeBorder(left, scratch.padded_left, 0, 0, kImageBorder, kImageBorder, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, scratch.padded_right, 0, 0, kImageBorder, kImageBorder, cv::BORDER_REPLICATE);
  disparity.create(left.size());
  if (sigma) sigma->create(left.size());
  scratch.refined.Create(left.size());
  scratch.unknown.assign(Padded(left.cols) + 2 * kRowMargin, 0);
  const float gain = MeasureGain(left, right, given);
  const RefineLimits limits = {static_cast<std::int16_t>(std::lround(settings_.max_jump_px * kUnitsPerPx)),
                               static_cast<std::int16_t>(std::lround(gain * 8192)), settings_.max_step_px,
                               settings_.given_sigma_px};
  for (int iteration = 1; iteration <= settings_.iterations; ++iteration) {
    const bool last = iteration == settings_.iterations;
    ParallelFor(num_strips, [&](int strip) {
      const int top = strip * kRowsPerStrip;
      RefineStrip(top, std::min(top + kRowsPerStrip, height), limits, given, steepness,
                  last ? &disparity : nullptr, last ? sigma : nullptr);
    });
    if (!last) std::swap(given, scratch.refined);
  }
}

/// Three steps, each a few rows behind the one before.
void Refiner::RefineStrip(int top, int bottom, const RefineLimits& limits, const UnitImage& given,
                          const Steepness& steepness, cv::Mat1f* disparity, cv::Mat1f* sigma) {
  const int width = scratch_->padded_left.cols - 2 * kImageBorder, height = scratch_->padded_left.rows;
  StripRows& rows = scratch_->rows.local();
  rows.Prepare(width);
  const auto given_row = [&](int v) {
    return v >= 0 && v < height ? given.Row(v) : scratch_->unknown.data() + kRowMargin;
  };
  for (int v = top - kReach; v < bottom + kReach; ++v) {
    const std::int16_t* around[] = {given_row(v - 2), given_row(v - 1), given_row(v), given_row(v + 1),
                                    given_row(v + 2)};
    const int v_image = std::clamp(v, 0, height - 1);
    ResidualRow& row = rows.At(v);
    row.any_steep =
        steepness.surfaces && steepness.surfaces->SlopesOfRow(v_image, steepness.scale, width, row.slope);
    HWY_DYNAMIC_DISPATCH(DisparitiesOfColumns)(around, row, width, rows.columns);
    HWY_DYNAMIC_DISPATCH(ResidualsOfRow)
    (&scratch_->padded_left(v_image, kImageBorder), &scratch_->padded_right(v_image, kImageBorder), around,
     rows.columns, width, limits, row);
    HWY_DYNAMIC_DISPATCH(MoveColumnSums)(row, rows.At(v - kRing + 1), width, rows.sums);

    const int v_refined = v - kReach;
    if (v_refined < top) continue;
    // Whole vectors are written to the results at once, others would reach into the next row.
    const bool in_place = width % kWholeVectors == 0;
    float* const refined = disparity && in_place ? (*disparity)[v_refined] : rows.disparity;
    float* const refined_sigma = !sigma ? nullptr : in_place ? (*sigma)[v_refined] : rows.sigma;
    HWY_DYNAMIC_DISPATCH(RefineRow)
    (rows.Around(v_refined).data(), rows.sums, width, limits, refined, refined_sigma);
    if (!disparity) ToUnits(refined, width, scratch_->refined.Row(v_refined));
    if (in_place) continue;
    if (disparity) std::memcpy((*disparity)[v_refined], refined, sizeof(float) * width);
    if (sigma) std::memcpy((*sigma)[v_refined], refined_sigma, sizeof(float) * width);
  }
}

}  // namespace terrace
#endif  // HWY_ONCE
