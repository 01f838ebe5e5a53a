// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_support.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "polygonization/plane_support.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TERRACE_POLYGONIZATION_PLANE_SUPPORT_ONCE_
#define TERRACE_POLYGONIZATION_PLANE_SUPPORT_ONCE_
namespace terrace {

/// What a leaf on a plane counts for, however loose the plane; for each factor of e that it is tighter than
/// the cell; and how much less at three standard deviations.
constexpr float kLoose = 1.9F;
constexpr float kTight = 0.5F;
constexpr float kDistance = 4.5F;
/// The noise of a leaf is what it may be at worst; a plane is also tried at these shares of it.
constexpr std::size_t kNumScales = 3;
constexpr std::array<float, kNumScales> kScales = {1.0F, 0.5F, 0.25F};
constexpr std::array<float, kNumScales> kLogScales = {0.0F, -0.693147F, -1.386294F};
constexpr float kLog2 = 0.693147F;
constexpr int kMantissaBits = 23;

/// Of leaves by their number modulo kLanes, for each scale.
using SupportSums = std::array<std::array<float, SurfelColumns::kLanes>, kNumScales>;

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, SurfelColumns::kLanes>;
using Values = hn::Vec<Lanes>;

/// Natural logarithm of positive numbers, within 0.06: straight between the powers of two.
HWY_INLINE Values LogOf(Values x) {
  const Lanes d;
  const hn::RebindToSigned<Lanes> di;
  const auto bits = hn::Sub(hn::BitCast(di, x), hn::Set(di, std::bit_cast<std::int32_t>(1.0F)));
  return hn::Mul(hn::Set(d, kLog2 / static_cast<float>(1 << kMantissaBits)), hn::ConvertTo(d, bits));
}

void SumSupport(const SurfelColumns& leaves, const InlierLimits& limits, const CellPlane& plane,
                SupportSums* sums) {
  const Lanes d;
  const auto zero = hn::Zero(d);
  const auto nx = hn::Set(d, plane.normal.x()), ny = hn::Set(d, plane.normal.y()),
             nz = hn::Set(d, plane.normal.z()), offset = hn::Set(d, plane.offset_m);
  const auto least_m = hn::Set(d, limits.least_m), most_m = hn::Set(d, limits.most_m),
             cell_m = hn::Set(d, limits.cell_size_m), one = hn::Set(d, 1.0F);
  const auto per_tightest = hn::Div(one, least_m);
  const auto log_tightest = LogOf(hn::Mul(cell_m, per_tightest));
  const auto along_normal = [&](SurfelColumns::Column first, std::size_t i) HWY_ATTR {
    const float *x = leaves.column(first) + i, *y = x + leaves.size(), *z = y + leaves.size();
    return hn::Add(hn::Add(hn::Mul(nx, hn::LoadU(d, x)), hn::Mul(ny, hn::LoadU(d, y))),
                   hn::Mul(nz, hn::LoadU(d, z)));
  };
  for (std::size_t i = 0; i < leaves.size(); i += hn::Lanes(d)) {
    const auto facing = hn::Neg(along_normal(SurfelColumns::kViewX, i));
    const auto distance = hn::Sub(along_normal(SurfelColumns::kX, i), offset);
    const auto noise = hn::Mul(hn::LoadU(d, leaves.column(SurfelColumns::kThreeSigmas) + i), facing);
    const auto allowed = hn::Min(hn::Max(noise, least_m), most_m);
    const auto belongs =
        hn::And(hn::Ge(facing, hn::Set(d, kLeastFacing)), hn::Lt(hn::Abs(distance), allowed));
    const auto area = hn::IfThenElseZero(belongs, hn::LoadU(d, leaves.column(SurfelColumns::kArea) + i));
    const auto per_allowed = hn::Div(one, allowed);
    const auto squared = hn::Mul(hn::Set(d, kDistance), hn::Mul(distance, distance));
    const auto loss = hn::Mul(squared, hn::Mul(per_allowed, per_allowed));
    const auto most_loss = hn::Mul(squared, hn::Mul(per_tightest, per_tightest));
    const auto log_allowed = LogOf(hn::Mul(cell_m, per_allowed));
    for (std::size_t k = 0; k < kNumScales; ++k) {
      const auto tight =
          hn::Mul(hn::Set(d, kTight), hn::Min(hn::Sub(log_allowed, hn::Set(d, kLogScales[k])), log_tightest));
      const auto loss_k = hn::Min(hn::Mul(loss, hn::Set(d, 1.0F / (kScales[k] * kScales[k]))), most_loss);
      const auto support = hn::Max(zero, hn::Sub(hn::Add(hn::Set(d, kLoose), tight), loss_k));
      float* const sum = (*sums)[k].data() + i % SurfelColumns::kLanes;
      hn::StoreU(hn::Add(hn::LoadU(d, sum), hn::Mul(area, support)), d, sum);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(SumSupport);

void SurfelColumns::Assign(const std::vector<Surfel>& surfels, const std::vector<int>& indices) {
  size_ = (indices.size() + kLanes - 1) / kLanes * kLanes;
  values_.assign(kNumColumns * size_, 0.0F);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Surfel& s = surfels[static_cast<std::size_t>(indices[i])];
    const std::array<float, kNumColumns> row{
        s.mean.x(),         s.mean.y(), s.mean.z(), s.view.x(), s.view.y(), s.view.z(), 3.0F * s.sigma_view_m,
        s.size_m * s.size_m};
    for (std::size_t c = 0; c < row.size(); ++c) values_[c * size_ + i] = row[c];
  }
}

float Explained(const SurfelColumns& leaves, const InlierLimits& limits, CellPlane* plane) {
  SupportSums sums{};
  HWY_DYNAMIC_DISPATCH(SumSupport)(leaves, limits, *plane, &sums);
  std::array<float, kNumScales> totals{};
  for (std::size_t k = 0; k < kNumScales; ++k)
    for (const float sum : sums[k]) totals[k] += sum;
  const auto best = std::max_element(totals.begin(), totals.end());
  plane->scale = kScales[static_cast<std::size_t>(best - totals.begin())];
  return *best;
}

}  // namespace terrace
#endif
