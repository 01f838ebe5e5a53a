// SPDX-License-Identifier: BSD-3-Clause
// What residuals and steps share, lane by lane, for the files that Highway compiles once per target.
#if defined(TERRACE_STEREO_REFINEMENT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRACE_STEREO_REFINEMENT_LANES_INL_H_
#undef TERRACE_STEREO_REFINEMENT_LANES_INL_H_
#else
#define TERRACE_STEREO_REFINEMENT_LANES_INL_H_
#endif

#include <cstdint>

#include <hwy/highway.h>

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

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#endif
