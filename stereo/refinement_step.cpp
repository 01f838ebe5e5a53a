// SPDX-License-Identifier: BSD-3-Clause
#include <limits>

#include "stereo/refinement_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/refinement_step.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stereo/refinement_lanes-inl.h"

#ifndef TERRACE_STEREO_REFINEMENT_STEP_ONCE_
#define TERRACE_STEREO_REFINEMENT_STEP_ONCE_
namespace terrace {

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

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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

/// Of the windows around the lanes from u on.
HWY_INLINE WindowSums SumsOfWindow(const ResidualRow* rows, const ColumnSums& columns, int u,
                                   std::int16_t max_jump) {
  const TagF df;
  const TagHalf16 d16;
  const auto across = [&](auto tag, const auto* sums) HWY_ATTR {
    return SumOfFive(hn::LoadU(tag, sums + u - 2), hn::LoadU(tag, sums + u - 1), hn::LoadU(tag, sums + u),
                     hn::LoadU(tag, sums + u + 1), hn::LoadU(tag, sums + u + 2));
  };
  WindowSums s = {ToFloat(across(d16, columns.n)), ToFloat(across(d16, columns.g)),
                  ToFloat(across(d16, columns.e)), across(df, columns.gg),
                  across(df, columns.ge),          across(df, columns.ee)};
  const auto at_edge = hn::LoadU(d16, rows[kReach].at_edge + u);
  if (hn::AllTrue(d16, hn::Eq(at_edge, hn::Zero(d16)))) return s;
  const auto edge = hn::Gt(ToFloat(at_edge), hn::Zero(df));
  const WindowSums same = SumsOfSurface(rows, u, max_jump);
  s.n = hn::IfThenElse(edge, same.n, s.n);
  s.g = hn::IfThenElse(edge, same.g, s.g);
  s.e = hn::IfThenElse(edge, same.e, s.e);
  s.gg = hn::IfThenElse(edge, same.gg, s.gg);
  s.ge = hn::IfThenElse(edge, same.ge, s.ge);
  s.ee = hn::IfThenElse(edge, same.ee, s.ee);
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

/// Standard deviation [px] of a disparity, by the texture that supports it.
/// @param gg        of the gradients, energy in the window
/// @param variance  of the images' noise
HWY_INLINE VecF SigmaOf(VecF gg, VecF variance) {
  const TagF df;
  const auto noise_in_texture = hn::Set(df, kNoiseInTexture);
  const auto unsupported_weight = hn::Set(df, 1.0f / (kUnsupportedSigma * kUnsupportedSigma));
  const auto noise_scale = hn::Set(df, kNoiseScale * kNoiseScale);
  const auto of_sampling = hn::Set(df, kSamplingSigma * kSamplingSigma);
  const auto texture = hn::Max(hn::Sub(gg, hn::Mul(variance, noise_in_texture)), hn::Zero(df));
  const auto information = hn::Add(texture, hn::Mul(variance, unsupported_weight));
  const auto of_noise = hn::Mul(noise_scale, hn::Mul(variance, Reciprocal(information)));
  const auto square = hn::Add(of_noise, of_sampling);
  return hn::Mul(square, ReciprocalSqrt(square));
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
    const WindowSums s = SumsOfWindow(rows, columns, u, limits.max_jump);
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
    const auto v_sigma = hn::IfThenElse(moves, SigmaOf(gg, variance), max_step);
    hn::StoreU(hn::IfThenElse(known, v_sigma, unknown), df, sigma + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(MoveColumnSums);
HWY_EXPORT(RefineRow);

void MoveColumnSums(const ResidualRow& entering, const ResidualRow& leaving, int width,
                    const ColumnSums& sums) {
  HWY_DYNAMIC_DISPATCH(MoveColumnSums)(entering, leaving, width, sums);
}

void RefineRow(const ResidualRow* rows, const ColumnSums& columns, int width, const RefineLimits& limits,
               float* disparity, float* sigma) {
  HWY_DYNAMIC_DISPATCH(RefineRow)(rows, columns, width, limits, disparity, sigma);
}

}  // namespace terrace
#endif  // HWY_ONCE
