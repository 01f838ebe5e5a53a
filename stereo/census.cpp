// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/census.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "core/parallel_for.h"

// Highway compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once for each instruction
// set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/census.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TERRACE_STEREO_CENSUS_ONCE_
#define TERRACE_STEREO_CENSUS_ONCE_
namespace terrace {
constexpr int kPairsPerPlane = 8;  // bits of a byte
}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One row of one plane. `pixel` is (0, v) of an image with at least kBorder + one vector of pixels around
/// it.
void CensusRow(const std::uint8_t* pixel, std::ptrdiff_t stride, int width, const CensusPair* pairs,
               std::uint8_t* plane) {
  const hn::ScalableTag<std::uint8_t> d;
  std::ptrdiff_t at_first[kPairsPerPlane], at_second[kPairsPerPlane];
  for (int i = 0; i < kPairsPerPlane; ++i) {
    at_first[i] = pairs[i].dv1 * stride + pairs[i].du1;
    at_second[i] = pairs[i].dv2 * stride + pairs[i].du2;
  }
  for (int u = 0; u < width; u += static_cast<int>(hn::Lanes(d))) {
    auto word = hn::Zero(d);
    for (int i = 0; i < kPairsPerPlane; ++i) {
      const auto first = hn::LoadU(d, pixel + u + at_first[i]), second = hn::LoadU(d, pixel + u + at_second[i]);
      const auto bit = hn::Set(d, static_cast<std::uint8_t>(1u << i));
      word = hn::Or(word, hn::IfThenElseZero(hn::Gt(first, second), bit));
    }
    hn::StoreU(word, d, plane + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(CensusRow);

std::vector<CensusPair> Census5x5() {
  std::vector<CensusPair> pairs;
  for (int dv = -2; dv <= 2; ++dv)
    for (int du = -2; du <= 2; ++du)
      if (du != 0 || dv != 0) pairs.push_back({du, dv, 0, 0});
  return pairs;
}

std::vector<CensusPair> Census9x7() {
  std::vector<CensusPair> pairs;
  for (int dv = -3; dv <= 0; ++dv)
    for (int du = -4; du <= 4; ++du)
      if (dv < 0 || du < 0) pairs.push_back({du, dv, -du, -dv});
  return pairs;
}

std::vector<CensusPair> CensusMixed() {
  std::vector<CensusPair> pairs;
  for (int dv = -3; dv <= 3; ++dv)
    for (int du = -3; du <= 3; ++du)
      if ((du != 0 || dv != 0) && (du + dv) % 2 == 0) pairs.push_back({du, dv, 0, 0});
  for (const auto& [du, dv] : {std::pair{1, 0}, {0, 1}, {2, 1}, {2, -1}, {1, 2}, {-1, 2}, {3, 0}, {4, 0}})
    pairs.push_back({du, dv, -du, -dv});
  return pairs;
}

void CensusImage::Compute(const cv::Mat1b& image, const std::vector<CensusPair>& pairs) {
  TERRACE_CHECK(!pairs.empty() && pairs.size() <= kPairsPerPlane * kNumPlanes, pairs.size());
  for (const CensusPair& p : pairs)
    TERRACE_CHECK(std::max({std::abs(p.du1), std::abs(p.dv1), std::abs(p.du2), std::abs(p.dv2)}) <= kBorder);
  width_ = image.cols;
  height_ = image.rows;
  // A pixel is not brighter than itself: where there is no pair, the bit is 0.
  std::array<CensusPair, kPairsPerPlane * kNumPlanes> all_pairs{};
  std::copy(pairs.begin(), pairs.end(), all_pairs.begin());
  stride_ = static_cast<std::size_t>(kLeftMargin + (width_ + 63) / 64 * 64 + kRightMargin);
  bytes_.Reserve(stride_ * kNumPlanes * height_);
  // Vectors may run past the last pixel of a row: by less than 64 bytes.
  cv::copyMakeBorder(image, padded_, kBorder, kBorder, kBorder, kBorder + 64, cv::BORDER_REPLICATE);
  ParallelFor(height_, [&](int v) {
    for (int plane = 0; plane < kNumPlanes; ++plane) {
      std::uint8_t* row = bytes_.data() + (static_cast<std::size_t>(v) * kNumPlanes + plane) * stride_;
      std::memset(row, 0, kLeftMargin);
      std::memset(row + kLeftMargin + width_, 0, stride_ - kLeftMargin - width_);
      HWY_DYNAMIC_DISPATCH(CensusRow)
      (&padded_(v + kBorder, kBorder), static_cast<std::ptrdiff_t>(padded_.step), width_,
       all_pairs.data() + kPairsPerPlane * plane, row + kLeftMargin);
    }
  });
}

}  // namespace terrace
#endif  // HWY_ONCE
