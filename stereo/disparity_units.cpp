// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_units.h"

#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/disparity_units.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void ToUnitsOfRow(const float* disparity, int width, std::int16_t* units) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::Rebind<std::int16_t, decltype(df)> d16;
  const int lanes = static_cast<int>(hn::Lanes(df));
  const auto scale = hn::Set(df, UnitImage::kUnitsPerPx), half = hn::Set(df, 0.5f);
  const auto least = hn::Set(df, 1.0f), most = hn::Set(df, UnitImage::kMaxUnits);
  int u = 0;
  for (; u + lanes <= width; u += lanes) {
    const auto d = hn::LoadU(df, disparity + u);
    const auto scaled = hn::Min(hn::Max(hn::Add(hn::Mul(d, scale), half), least), most);
    const auto known = hn::IfThenElseZero(hn::Eq(d, d), scaled);
    hn::StoreU(hn::DemoteTo(d16, hn::ConvertTo(di, known)), d16, units + u);
  }
  for (; u < width; ++u) {
    const float scaled = disparity[u] * UnitImage::kUnitsPerPx + 0.5f;
    units[u] = std::isnan(scaled)
                   ? 0
                   : static_cast<std::int16_t>(std::clamp<float>(scaled, 1.0f, UnitImage::kMaxUnits));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(ToUnitsOfRow);

void ToUnits(const float* disparity_px, int width, std::int16_t* units) {
  HWY_DYNAMIC_DISPATCH(ToUnitsOfRow)(disparity_px, width, units);
}

void UnitImage::Create(const cv::Size& size) {
  if (size == size_) return;
  size_ = size;
  rows_ = cv::Mat_<std::int16_t>::zeros(size.height, (size.width + 63) / 64 * 64 + 2 * kMargin);
}

void UnitImage::Set(const cv::Mat1f& disparity_px) {
  Create(disparity_px.size());
  ParallelFor(size_.height, [&](int v) { ToUnits(disparity_px[v], size_.width, Row(v)); });
}

}  // namespace terrace
#endif  // HWY_ONCE
