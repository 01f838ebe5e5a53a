// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/patch_search.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/patch_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Sums of absolute differences between a patch and those that begin at right, right - 1, right - 2 ...
void PatchDifferences(const std::uint8_t* left, std::size_t left_stride, const std::uint8_t* right,
                      std::size_t right_stride, int count, std::uint16_t* sums) {
  const hn::FixedTag<std::uint8_t, kPatchWidth> d;
  const hn::Repartition<std::uint64_t, decltype(d)> d64;
  hn::Vec<decltype(d)> rows[kPatchHeight];
  for (int r = 0; r < kPatchHeight; ++r)
    rows[r] = hn::LoadU(d, left + static_cast<std::size_t>(r) * left_stride);
  for (int k = 0; k < count; ++k) {
    auto sum = hn::Zero(d64);
    for (int r = 0; r < kPatchHeight; ++r) {
      const auto other = hn::LoadU(d, right - k + static_cast<std::size_t>(r) * right_stride);
      const auto difference = hn::Or(hn::SaturatedSub(rows[r], other), hn::SaturatedSub(other, rows[r]));
      sum = hn::Add(sum, hn::SumsOf8(difference));
    }
    HWY_ALIGN std::uint64_t both[2];
    hn::Store(sum, d64, both);
    sums[k] = static_cast<std::uint16_t>(both[0] + both[1]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(PatchDifferences);

namespace {

constexpr int kPatchPixels = kPatchWidth * kPatchHeight;
constexpr int kMinGradient = 2 * kPatchPixels;  // sum over a patch, in each direction
constexpr int kMaxDifference = 16 * kPatchPixels;
constexpr int kMaxRows = 25;
constexpr int kMaxDisparities = 256;

bool HasTexture(const cv::Mat1b& image, int left, int top) {
  int along = 0, across = 0;
  for (int v = top; v < top + kPatchHeight; ++v) {
    const std::uint8_t *row = image[v], *next = image[v + 1];
    for (int u = left; u < left + kPatchWidth; ++u) {
      along += std::abs(row[u + 1] - row[u]);
      across += std::abs(next[u] - row[u]);
    }
  }
  return std::min(along, across) >= kMinGradient;
}

}  // namespace

std::optional<PatchMatch> FindPatch(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v,
                                    const PatchRange& range) {
  const int first_u = u - kPatchWidth / 2, first_v = v - kPatchHeight / 2;
  const int num_rows = range.most_rows - range.least_rows + 1;
  const int count = std::min({range.num_disparities, kMaxDisparities, first_u + 1});
  if (first_u < 0 || first_u + kPatchWidth >= left.cols || first_v < 0 ||
      first_v + kPatchHeight >= left.rows || first_v + range.least_rows < 0 ||
      first_v + range.most_rows + kPatchHeight > right.rows || num_rows > kMaxRows || count < 3 ||
      !HasTexture(left, first_u, first_v))
    return std::nullopt;
  std::array<std::uint16_t, kMaxRows * kMaxDisparities> sums;
  PatchMatch best;
  int least = kMaxDifference;
  for (int i = 0; i < num_rows; ++i) {
    std::uint16_t* of_row = sums.data() + i * kMaxDisparities;
    HWY_DYNAMIC_DISPATCH(PatchDifferences)
    (left[first_v] + first_u, left.step, right[first_v + range.least_rows + i] + first_u, right.step, count,
     of_row);
    const std::uint16_t* lowest = std::min_element(of_row, of_row + count);
    if (*lowest < least) least = *lowest, best = {static_cast<int>(lowest - of_row), range.least_rows + i};
  }
  if (least == kMaxDifference) return std::nullopt;
  // No other place may differ by less than a quarter more.
  for (int i = 0; i < num_rows; ++i) {
    const bool beside = std::abs(range.least_rows + i - best.rows) <= 1;
    for (int k = 0; k < count; ++k)
      if (4 * sums[i * kMaxDisparities + k] < 5 * least + kPatchPixels &&
          !(beside && std::abs(k - best.disparity) <= 2))
        return std::nullopt;
  }
  return best;
}

}  // namespace terrace
#endif  // HWY_ONCE
