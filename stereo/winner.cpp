// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/winner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/winner.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stereo/unknown_disparity.h"
#include "stereo/vector_minimum-inl.h"

#ifndef TERRACE_STEREO_WINNER_ONCE_
#define TERRACE_STEREO_WINNER_ONCE_
namespace terrace {
constexpr std::uint8_t kSaturated = 255;  // a sum that may stand for anything above
/// A claim on a pixel of the right view is its sum times this and the disparity: the less the better.
constexpr std::int32_t kClaimSum = 1 << 16;
}  // namespace terrace
#endif

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
void FindWinners(D d, const SumsRow& row, const std::uint8_t* limit_of_sum, const WinnersRow& winners) {
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
      std::uint64_t best = 0;
      for (int k = 0; index < 0; k += 64) {
        best = NotAbove(d, sums + i * n + k, std::min(n - k, 64), minimum);
        if (best != 0) index = k + std::countr_zero(best);
      }
      // Rivals: as good within the margin, but not next to the best. Mostly those are the same sums.
      bool unique = true;
      const std::uint8_t limit = limit_of_sum[minimum];
      const bool seen = n <= 64 && limit == minimum;
      for (int k = 0; k < n; k += 64) {
        std::uint64_t bits = seen ? best : NotAbove(d, sums + i * n + k, std::min(n - k, 64), limit);
        const int first = index - 1 - k;  // clear the bits first ... first + 2
        if (first >= 0 && first < 64)
          bits &= ~(std::uint64_t{7} << first);
        else if (first < 0 && first > -3)
          bits &= ~(std::uint64_t{7} >> -first);
        unique = unique && bits == 0;
      }
      winners.index[u0 + i] = static_cast<std::uint8_t>(index);
      winners.sum[u0 + i] = minimum;
      winners.unique[u0 + i] = unique ? 255 : 0;
      const bool inner = index > 0 && index + 1 < n;
      winners.before[u0 + i] = inner ? sums[i * n + index - 1] : minimum;
      winners.behind[u0 + i] = inner ? sums[i * n + index + 1] : minimum;
    }
  }
}

/// FindWinners for 16 disparities: several pixels in a vector.
template <class D>
void FindWinnersOfBlocks(D d, const SumsRow& row, const std::uint8_t* limit_of_sum,
                         const WinnersRow& winners) {
  constexpr int kNumPixels = static_cast<int>(hn::MaxLanes(D())) / 16;
  HWY_ALIGN std::uint8_t minima[16 * kNumPixels];
  for (int u0 = 0; u0 < row.width; u0 += kNumPixels) {
    const std::uint8_t* sums = row.sums + static_cast<std::ptrdiff_t>(u0) * 16;
    const auto v = hn::Load(d, sums);
    const auto minimum = MinimumOfBlocks(d, v);
    hn::Store(minimum, d, minima);
    std::uint32_t limits = 0;
    for (int i = 0; i < kNumPixels; ++i) limits |= std::uint32_t{limit_of_sum[minima[16 * i]]} << (8 * i);
    const auto bits_of = [&](auto mask) HWY_ATTR {
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, mask, bytes);
      std::uint64_t bits;
      std::memcpy(&bits, bytes, 8);
      return bits;
    };
    std::uint64_t best = bits_of(hn::Eq(v, minimum));
    std::uint64_t rivals = bits_of(hn::Eq(hn::Min(v, Replicate(d, limits)), v));
    for (int i = 0; i < kNumPixels; ++i, sums += 16, best >>= 16, rivals >>= 16) {
      const int index = std::countr_zero(best);
      const std::uint64_t beside = std::uint64_t{7} << index >> 1;
      const bool inner = index > 0 && index < 15;
      winners.index[u0 + i] = static_cast<std::uint8_t>(index);
      winners.sum[u0 + i] = minima[16 * i];
      winners.unique[u0 + i] = (rivals & 0xFFFF & ~beside) == 0 ? 255 : 0;
      winners.before[u0 + i] = inner ? sums[index - 1] : minima[16 * i];
      winners.behind[u0 + i] = inner ? sums[index + 1] : minima[16 * i];
    }
  }
}

void FindWinnersOfRow(const SumsRow& row, const std::uint8_t* limit_of_sum, const WinnersRow& winners) {
  if (row.num_disparities % 64 == 0)
    FindWinners(ByteTag<64>(), row, limit_of_sum, winners);
  else if (row.num_disparities % 32 == 0)
    FindWinners(ByteTag<32>(), row, limit_of_sum, winners);
  else if (row.num_disparities == 16)
    FindWinnersOfBlocks(ByteTag<64>(), row, limit_of_sum, winners);
  else
    FindWinners(ByteTag<16>(), row, limit_of_sum, winners);
}

/// The disparities of the left view's winners that the right view's agree with.
/// @param right_claims  the best on each pixel of the right view
void DisparitiesOfRow(const SumsRow& row, const WinnersRow& winners, const std::int32_t* right_claims,
                      int max_error, float* disparity) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::Rebind<std::int16_t, decltype(df)> d16;
  const hn::Rebind<std::uint8_t, decltype(df)> d8;
  const auto half = hn::Set(df, 0.5f), one = hn::Set(df, 1.0f), unknown = hn::Set(df, kUnknownDisparity);
  const auto saturated = hn::Set(di, kSaturated), error = hn::Set(di, max_error + 1);
  const auto bytes = [&](const std::uint8_t* p) HWY_ATTR { return hn::PromoteTo(di, hn::LoadU(d8, p)); };
  for (int u = 0; u < row.width; u += static_cast<int>(hn::Lanes(df))) {
    const auto index = bytes(winners.index + u), sum = bytes(winners.sum + u);
    const auto first = hn::PromoteTo(di, hn::LoadU(d16, row.first + u));
    const auto d = hn::Sub(hn::Add(first, hn::Set(di, row.num_disparities - 1)), index);
    const auto x = hn::Sub(hn::Iota(di, u), d);
    const auto in_image = hn::Min(hn::Max(x, hn::Zero(di)), hn::Set(di, row.width - 1));
    const auto claim = hn::GatherIndex(di, right_claims, in_image);
    const auto in_right = hn::And(claim, hn::Set(di, kClaimSum - 1));
    const auto possible = hn::And(hn::Gt(d, hn::Set(di, -1)), hn::Gt(x, hn::Set(di, -1)));
    const auto known =
        hn::And(hn::And(hn::Ne(bytes(winners.unique + u), hn::Zero(di)), hn::Ne(sum, saturated)),
                hn::And(possible, hn::Lt(hn::Abs(hn::Sub(in_right, d)), error)));
    // Where between -0.5 and 0.5 the parabola through the best sum and its neighbours has its lowest point.
    // Sums run from large disparities to small ones.
    const auto below = bytes(winners.behind + u), above = bytes(winners.before + u);
    const auto curvature = hn::Sub(hn::Add(below, above), hn::Add(sum, sum));
    const auto offset = hn::Div(hn::Mul(half, hn::ConvertTo(df, hn::Sub(below, above))),
                                hn::Max(hn::ConvertTo(df, curvature), one));
    const auto exact = hn::Add(hn::ConvertTo(df, d), offset);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(df, known), exact, unknown), df, disparity + u);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(FindWinnersOfRow);
HWY_EXPORT(DisparitiesOfRow);

namespace {

// Before it, all disparities that stay in the right image are neighbours of each other: nothing to choose
// from.
constexpr int kFirstChoice = 3;
constexpr int kAnyError = 1000;
constexpr int kPadding = 64;  // elements behind the rows, which vectors may touch

}  // namespace

WinnerChooser::WinnerChooser(const WinnerRules& rules) : rules_(rules) {
  for (int sum = 0; sum < 256; ++sum)
    limit_of_sum_[sum] = static_cast<std::uint8_t>(std::min(255, sum + sum * rules.uniqueness_percent / 100));
}

void WinnerChooser::Choose(const SumsRow& row, float* disparity) {
  const int n = row.num_disparities;
  const std::size_t padded_width = static_cast<std::size_t>((row.width + 15) / 16 * 16 + kPadding);
  bytes_.resize(kNumBytes * padded_width);
  const WinnersRow winners = {bytes_.data(), bytes_.data() + padded_width, bytes_.data() + 2 * padded_width,
                              bytes_.data() + 3 * padded_width, bytes_.data() + 4 * padded_width};
  HWY_DYNAMIC_DISPATCH(FindWinnersOfRow)(row, limit_of_sum_.data(), winners);

  // The right view: of all pixels that claim a pixel of the right image, the one with the least sum has it.
  // Who claims a pixel is who asks for it later. Without branches, as nobody can predict them.
  right_claims_.assign(row.width, kClaimSum * (kSaturated + 1));
  std::int32_t* const right_claims = right_claims_.data();
  for (int u = 0, width = row.width; u < width; ++u) {
    const int d = row.first[u] + n - 1 - winners.index[u];
    if (d < 0 || d > u) continue;
    right_claims[u - d] = std::min(right_claims[u - d], kClaimSum * winners.sum[u] + d);
  }
  disparity_.resize(padded_width);
  const int max_error = rules_.max_left_right_error >= 0 ? rules_.max_left_right_error : kAnyError;
  HWY_DYNAMIC_DISPATCH(DisparitiesOfRow)(row, winners, right_claims, max_error, disparity_.data());
  std::fill_n(disparity_.begin(), std::min(kFirstChoice, row.width), kUnknownDisparity);
  std::copy_n(disparity_.begin(), row.width, disparity);
}

}  // namespace terrace
#endif  // HWY_ONCE
