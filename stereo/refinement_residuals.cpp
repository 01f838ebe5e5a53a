// SPDX-License-Identifier: BSD-3-Clause
#include <bit>
#include <cstring>

#include "stereo/refinement_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/refinement_residuals.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stereo/refinement_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag8 = hn::Rebind<std::uint8_t, Tag16>;

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
    const auto other_surface = [&](const std::int16_t* p)
                                   HWY_ATTR { return hn::Gt(hn::Abs(hn::Sub(hn::LoadU(d, p), own)), jump); };
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

/// The four pixels around each place of the right image between whole pixels.
struct FourPixels {
  hn::Vec<Tag8> q0, q1, q2, q3;
};

/// @param row    the right image from the first lane's own column on
/// @param whole  disparity of each lane, rounded up
HWY_INLINE FourPixels PixelsAround(const std::uint8_t* row, hn::Vec<Tag8> whole) {
  const Tag8 d8;
  FourPixels q{hn::Zero(d8), hn::Zero(d8), hn::Zero(d8), hn::Zero(d8)};
  HWY_ALIGN std::uint8_t distances[hn::MaxLanes(d8)];
  hn::Store(whole, d8, distances);
  // Neighbours of equal whole disparity are neighbours there as well.
  std::uint64_t rest = ~std::uint64_t{0} >> (64 - hn::Lanes(d8));
  while (rest != 0) {
    const std::uint8_t distance = distances[std::countr_zero(rest)];
    const auto here = hn::Eq(whole, hn::Set(d8, distance));
    const std::uint8_t* first = row - distance - 1;
    q.q0 = hn::IfThenElse(here, hn::LoadU(d8, first), q.q0);
    q.q1 = hn::IfThenElse(here, hn::LoadU(d8, first + 1), q.q1);
    q.q2 = hn::IfThenElse(here, hn::LoadU(d8, first + 2), q.q2);
    q.q3 = hn::IfThenElse(here, hn::LoadU(d8, first + 3), q.q3);
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d8, here, bytes);
    std::uint64_t done;
    std::memcpy(&done, bytes, 8);
    rest &= ~done;
  }
  return q;
}

/// The cubic of Catmull and Rom through the four pixels, in sixteenths of a grey level.
/// @param f  how far between the inner two, times 2^15
HWY_INLINE Vec16 Interpolated(const FourPixels& q, Vec16 f) {
  const Tag16 d;
  const auto p0 = hn::PromoteTo(d, q.q0), p1 = hn::PromoteTo(d, q.q1);
  const auto p2 = hn::PromoteTo(d, q.q2), p3 = hn::PromoteTo(d, q.q3);
  // p1 + f (c1 + f (c2 + f c3)).
  const auto p20 = hn::Sub(p2, p0), p12 = hn::Sub(p1, p2);
  const auto c1 = hn::ShiftLeft<3>(p20);
  const auto c3 = hn::ShiftLeft<3>(hn::Sub(hn::Add(hn::Add(p12, p12), hn::Sub(p3, p2)), hn::Sub(p0, p1)));
  const auto c2 = hn::Sub(hn::Sub(hn::ShiftLeft<4>(hn::Neg(p12)), c1), c3);
  const auto m1 = hn::MulFixedPoint15(f, c3);
  const auto m2 = hn::MulFixedPoint15(f, hn::Add(c2, m1));
  return hn::Add(hn::ShiftLeft<4>(p1), hn::MulFixedPoint15(f, hn::Add(c1, m2)));
}

/// Residual and gradient of the middle one of five rows. The right image is sampled by the cubic of Catmull
/// and Rom. The gradient is the left image's alone: between whole pixels the right one's noise is smoothed,
/// and a gradient with a share of it pulls disparities there.
template <bool kSteep>
void ResidualsOfRowWith(const std::uint8_t* left, const std::uint8_t* right, const std::int16_t* const* rows,
                        const ColumnDisparities& columns, int width, const RefineLimits& limits,
                        const ResidualRow& out) {
  const Tag16 d;
  const Tag8 d8;
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
    const auto whole8 = hn::DemoteTo(d8, hn::IfThenElseZero(valid, whole));
    const auto value = Interpolated(PixelsAround(right + u, whole8), hn::ShiftLeft<15 - kUnitBits>(fraction));
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

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(DisparitiesOfColumns);
HWY_EXPORT(ResidualsOfRow);

void DisparitiesOfColumns(const std::int16_t* const* rows, const ResidualRow& middle, int width,
                          const ColumnDisparities& columns) {
  HWY_DYNAMIC_DISPATCH(DisparitiesOfColumns)(rows, middle, width, columns);
}

void ResidualsOfRow(const std::uint8_t* left, const std::uint8_t* right, const std::int16_t* const* rows,
                    const ColumnDisparities& columns, int width, const RefineLimits& limits,
                    const ResidualRow& out) {
  HWY_DYNAMIC_DISPATCH(ResidualsOfRow)(left, right, rows, columns, width, limits, out);
}

}  // namespace terrace
#endif  // HWY_ONCE
