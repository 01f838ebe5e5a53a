// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/winner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/winner.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stereo/vector_minimum-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Bit k of the result: sums[k] <= limit, for the 64 sums from `sums` on or as many as there are.
template <class D>
HWY_INLINE std::uint64_t NotAbove(D d, const std::uint8_t* sums, int count, std::uint8_t limit) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  const auto v_limit = hn::Set(d, limit);
  std::uint64_t bits = 0;
  for (int k = 0; k < count; k += kLanes) {
    std::uint8_t bytes[8] = {};
    const auto v = hn::Load(d, sums + k);
    hn::StoreMaskBits(d, hn::Eq(hn::Min(v, v_limit), v), bytes);
    std::uint64_t part;
    std::memcpy(&part, bytes, 8);
    bits |= part << k;
  }
  return bits;
}

template <class D>
void FindWinners(D d, const SumsRow& row, const std::uint8_t* limit_of_sum, WinnerChooser::Winner* winners) {
  const int n = row.num_disparities;
  const int lanes = static_cast<int>(hn::MaxLanes(d));
  for (int u0 = 0; u0 < row.width; u0 += 16) {
    const std::uint8_t* sums = row.sums + static_cast<std::ptrdiff_t>(u0) * n;
    hn::Vec<Tag16> least[16];
    for (int i = 0; i < 16; ++i) {
      auto m = hn::Load(d, sums + i * n);
      for (int k = lanes; k < n; k += lanes) m = hn::Min(m, hn::Load(d, sums + i * n + k));
      least[i] = FoldTo16(d, m);
    }
    HWY_ALIGN std::uint8_t minima[16];
    hn::Store(MinimumOfEach(least), Tag16(), minima);
    for (int i = 0; i < 16; ++i) {
      const std::uint8_t minimum = minima[i];
      int index = -1;
      for (int k = 0; index < 0; k += 64) {
        const std::uint64_t bits = NotAbove(d, sums + i * n + k, std::min(n - k, 64), minimum);
        if (bits != 0) index = k + std::countr_zero(bits);
      }
      // Rivals: as good within the margin, but not next to the best.
      bool unique = true;
      const std::uint8_t limit = limit_of_sum[minimum];
      for (int k = 0; k < n; k += 64) {
        std::uint64_t bits = NotAbove(d, sums + i * n + k, std::min(n - k, 64), limit);
        const int first = index - 1 - k;  // clear the bits first ... first + 2
        if (first >= 0 && first < 64)
          bits &= ~(std::uint64_t{7} << first);
        else if (first < 0 && first > -3)
          bits &= ~(std::uint64_t{7} >> -first);
        unique = unique && bits == 0;
      }
      winners[u0 + i] = {static_cast<std::uint8_t>(index), minimum, unique};
    }
  }
}

void FindWinnersOfRow(const SumsRow& row, const std::uint8_t* limit_of_sum, WinnerChooser::Winner* winners) {
  if (row.num_disparities % 64 == 0)
    FindWinners(ByteTag<64>(), row, limit_of_sum, winners);
  else if (row.num_disparities % 32 == 0)
    FindWinners(ByteTag<32>(), row, limit_of_sum, winners);
  else
    FindWinners(ByteTag<16>(), row, limit_of_sum, winners);
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(FindWinnersOfRow);

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
// Before it, all disparities that stay in the right image are neighbours of each other: nothing to choose
// from.
constexpr int kFirstChoice = 3;
constexpr std::int16_t kNobody = -1000;
constexpr std::uint8_t kSaturated = 255;  // a sum that may stand for anything above

/// Where between -0.5 and 0.5 the parabola through three sums has its lowest point.
float ParabolaOffset(int below, int best, int above) {
  const int curvature = below + above - 2 * best;
  return curvature > 0 ? 0.5f * static_cast<float>(below - above) / static_cast<float>(curvature) : 0.0f;
}

}  // namespace

WinnerChooser::WinnerChooser(const WinnerRules& rules) : rules_(rules) {
  for (int sum = 0; sum < 256; ++sum)
    limit_of_sum_[sum] = static_cast<std::uint8_t>(std::min(255, sum + sum * rules.uniqueness_percent / 100));
}

void WinnerChooser::Choose(const SumsRow& row, float* disparity) {
  const int n = row.num_disparities;
  winners_.resize((row.width + 15) / 16 * 16);
  HWY_DYNAMIC_DISPATCH(FindWinnersOfRow)(row, limit_of_sum_.data(), winners_.data());

  // The right view: of all pixels that claim a pixel of the right image, the one with the least sum has it.
  right_disparity_.assign(row.width, kNobody);
  right_sum_.assign(row.width, kSaturated);
  for (int u = 0; u < row.width; ++u) {
    const int d = row.first[u] + n - 1 - winners_[u].index;
    if (u >= d && winners_[u].sum < right_sum_[u - d]) {
      right_sum_[u - d] = winners_[u].sum;
      right_disparity_[u - d] = static_cast<std::int16_t>(d);
    }
  }
  std::fill(disparity, disparity + std::min(kFirstChoice, row.width), kUnknown);
  for (int u = kFirstChoice; u < row.width; ++u) {
    const Winner& w = winners_[u];
    const int d = row.first[u] + n - 1 - w.index;
    disparity[u] = kUnknown;
    if (!w.unique || w.sum == kSaturated || u < d) continue;
    if (rules_.max_left_right_error >= 0 &&
        std::abs(right_disparity_[u - d] - d) > rules_.max_left_right_error)
      continue;
    float offset = 0.0f;
    if (w.index > 0 && w.index + 1 < n) {
      const std::uint8_t* sums = row.sums + static_cast<std::ptrdiff_t>(u) * n + w.index;
      offset = ParabolaOffset(sums[1], w.sum, sums[-1]);  // sums run from large disparities to small ones
    }
    disparity[u] = static_cast<float>(d) + offset;
  }
}

}  // namespace terrace
#endif  // HWY_ONCE
