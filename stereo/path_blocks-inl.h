// SPDX-License-Identifier: BSD-3-Clause
// The same for ranges of 16 disparities, several pixels in one vector; for the files that Highway compiles
// once per target.
#if defined(TERRACE_STEREO_PATH_BLOCKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRACE_STEREO_PATH_BLOCKS_INL_H_
#undef TERRACE_STEREO_PATH_BLOCKS_INL_H_
#else
#define TERRACE_STEREO_PATH_BLOCKS_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "stereo/path_layout.h"
#include "stereo/vector_minimum-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Ranges of 16 disparities leave most of a vector empty. As many pixels as it has blocks of 16 bytes are
/// worked on together: neighbours in a row by the vertical paths, rows by the horizontal ones. Their state is
/// L(p, d) - min L(p), inverted: what is outside the range is then 0, which byte shifts and look-ups give.
template <class D>
class Blocks {
 public:
  static constexpr int kNum = static_cast<int>(hn::MaxLanes(D())) / 16;
  using V = hn::Vec<D>;

  /// The next bytes from `bytes` on, one for each block; the others are 0.
  static HWY_INLINE std::uint32_t Next(const std::uint8_t* bytes) {
    std::uint32_t word;
    std::memcpy(&word, bytes, 4);
    return kNum == 4 ? word : word & ((1u << (8 * kNum % 32)) - 1);
  }
  /// 16 bytes from `of(i)` on in block i.
  template <class Of>
  static HWY_INLINE V Load(const Of& of) {
    return LoadFrom<0>(D(), of);
  }
  template <class Of>
  static HWY_INLINE void Store(V v, const Of& of) {
    StoreTo<0>(D(), v, of);
  }
  /// The inverse of min(L(q, d), L(q, d -+ 1) + P1, P2).
  /// @param before  the state of q
  /// @param shifts  by which the index moves from p's range to that of q
  static HWY_INLINE V Best(V before, std::uint32_t shifts, bool negative, V p1, V p2) {
    const D d;
    V same = before, up = hn::ShiftLeftBytes<1>(before), down = hn::ShiftRightBytes<1>(d, before);
    if (shifts != 0) {
      const V shift = Replicate(d, shifts);
      const V iota = hn::LoadDup128(d, kIota);
      const V index = negative ? hn::Sub(iota, shift) : hn::Add(iota, shift);
      const auto look_up = [&](V at) HWY_ATTR {
        const V outside_has_high_bit = hn::SaturatedAdd(at, hn::Set(d, 0x70));
        return hn::TableLookupBytesOr0(before, hn::And(outside_has_high_bit, hn::Set(d, 0x8F)));
      };
      same = look_up(index);
      up = look_up(hn::Sub(index, hn::Set(d, 1)));
      down = look_up(hn::Add(index, hn::Set(d, 1)));
    }
    return hn::Max(hn::Max(same, hn::SaturatedSub(hn::Max(up, down), p1)), hn::Not(p2));
  }
  HWY_ALIGN static constexpr std::uint8_t kIota[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

 private:
  template <int kFirst, class DPart, class Of>
  static HWY_INLINE hn::Vec<DPart> LoadFrom(DPart d, const Of& of) {
    if constexpr (hn::MaxLanes(DPart()) == 16) {
      return hn::LoadU(d, of(kFirst));
    } else {
      const hn::Half<DPart> half;
      constexpr int kHalf = static_cast<int>(hn::MaxLanes(DPart())) / 32;
      const auto lower = LoadFrom<kFirst>(half, of);
      return hn::Combine(d, LoadFrom<kFirst + kHalf>(half, of), lower);
    }
  }
  template <int kFirst, class DPart, class Of>
  static HWY_INLINE void StoreTo(DPart d, hn::Vec<DPart> v, const Of& of) {
    if constexpr (hn::MaxLanes(DPart()) == 16) {
      hn::StoreU(v, d, of(kFirst));
    } else {
      const hn::Half<DPart> half;
      constexpr int kHalf = static_cast<int>(hn::MaxLanes(DPart())) / 32;
      StoreTo<kFirst>(half, hn::LowerHalf(half, v), of);
      StoreTo<kFirst + kHalf>(half, hn::UpperHalf(half, v), of);
    }
  }
};

/// Costs of the pixels from u on, one in each block.
template <class D>
HWY_INLINE hn::Vec<D> CostsOfBlocks(D d, const RowPointers& row, int u) {
  using B = Blocks<D>;
  const auto right_u = [&](int i) { return u + i - (row.first[u + i] + 15); };
  hn::Vec<D> words[CensusImage::kNumPlanes];
  auto cost = hn::Zero(d);
  for (int p = 0; p < CensusImage::kNumPlanes; ++p) {
    words[p] = Replicate(d, B::Next(row.left[p] + u));
    const auto right = B::Load([&](int i) { return row.right[p] + right_u(i); });
    cost = hn::Add(cost, hn::PopulationCount(hn::Xor(words[p], right)));
  }
  bool any_outside = false;
  for (int i = 0; i < B::kNum; ++i) any_outside |= right_u(i) < 0;
  if (any_outside) {
    std::uint32_t num_outside = 0;
    for (int i = 0; i < B::kNum; ++i)
      num_outside |= static_cast<std::uint32_t>(std::clamp(-right_u(i), 0, 16)) << (8 * i);
    const auto outside = hn::Lt(hn::LoadDup128(d, B::kIota), Replicate(d, num_outside));
    const auto shown = hn::Add(hn::Add(hn::PopulationCount(words[0]), hn::PopulationCount(words[1])),
                               hn::Add(hn::PopulationCount(words[2]), hn::PopulationCount(words[3])));
    cost = hn::IfThenElse(outside, hn::Min(shown, hn::Set(d, kMaxCostOutside)), cost);
  }
  return hn::Add(cost, hn::LoadDup128(d, row.prior_costs));
}

/// VerticalRow for ranges of 16.
template <bool kDiagonals, Sums kSums, class D>
void VerticalRowOfBlocks(D d, const RowPointers& row, int width, std::uint8_t p1, const StripMemory& memory) {
  using B = Blocks<D>;
  constexpr int kNumPaths = kDiagonals ? kMostFromRow : 1;
  const auto v_p1 = hn::Set(d, p1);
  const hn::FixedTag<std::int16_t, 8> d16;
  const hn::Rebind<std::int8_t, decltype(d16)> d8;
  for (int path = 0; path < kNumPaths; ++path) {
    std::int8_t* shifts = reinterpret_cast<std::int8_t*>(memory.shifts) + path * memory.padded_width;
    for (int u = 0; u < width; u += 8) {
      const auto shift = hn::Sub(hn::LoadU(d16, row.first_before[path] + u), hn::LoadU(d16, row.first + u));
      hn::StoreU(hn::DemoteTo(d8, shift), d8, shifts + u);
    }
    if (kFromColumn[path] < 0) shifts[0] = 0;  // where it begins
    if (kFromColumn[path] > 0) shifts[width - 1] = 0;
  }
  for (int u = 0; u < width; u += B::kNum) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(u) * 16;
    auto cost = hn::Undefined(d);
    if constexpr (kSums == Sums::kAdd) {
      cost = hn::Load(d, row.costs + at);
    } else {
      cost = CostsOfBlocks(d, row, u);
      if constexpr (kSums != Sums::kNone) hn::Store(cost, d, row.costs + at);
    }
    if constexpr (kSums == Sums::kCosts) continue;
    const auto step = [&](int path) HWY_ATTR {
      const std::ptrdiff_t in_paths = path * memory.path_bytes + at;
      const auto before = hn::LoadU(d, memory.paths[0] + in_paths + 16 * kFromColumn[path]);
      const auto best = B::Best(before, B::Next(memory.shifts + path * memory.padded_width + u), false, v_p1,
                                Replicate(d, B::Next(row.p2[path] + u)));
      const auto value = hn::Add(cost, hn::Not(best));
      hn::Store(hn::Not(hn::Sub(value, MinimumOfBlocks(d, value))), d, memory.paths[1] + in_paths);
      return value;
    };
    auto value = step(0);
    if constexpr (kDiagonals) value = hn::AverageRound(value, hn::AverageRound(step(1), step(2)));
    if constexpr (kSums == Sums::kSet) hn::Store(value, d, row.sums + at);
    if constexpr (kSums == Sums::kAdd)
      hn::Store(hn::SaturatedAdd(value, hn::Load(d, row.sums + at)), d, memory.row_sums + at);
  }
}

/// HorizontalRows for ranges of 16.
template <class D>
void HorizontalRowsOfBlocks(D d, const RowPointers* rows, int width, std::uint8_t p1, std::uint8_t* shifts,
                            std::uint8_t* p2) {
  using B = Blocks<D>;
  constexpr int kNumGroups = kRowsTogether / B::kNum;
  // From the left, rows interleaved; from the right it is the other way round. More than 16 is as good as
  // any.
  for (int r = 0; r < kRowsTogether; ++r) {
    const std::int16_t* first = rows[r].first;
    shifts[r] = shifts[width * kRowsTogether + r] = 0;
    for (int u = 1; u < width; ++u)
      shifts[u * kRowsTogether + r] = static_cast<std::uint8_t>(std::clamp(first[u - 1] - first[u], -99, 99));
    for (int u = 0; u <= width; ++u) p2[u * kRowsTogether + r] = rows[r].p2[0][u];
  }
  const auto v_p1 = hn::Set(d, p1);
  HWY_ALIGN std::uint8_t states[2][kNumGroups][B::kNum * 16];
  std::memset(states, 255, sizeof(states));
  for (int i = 0; i < width; ++i)
    for (int side = 0; side < 2; ++side)
      for (int g = 0; g < kNumGroups; ++g) {
        const int u = side == 0 ? i : width - 1 - i;
        const RowPointers* group = rows + g * B::kNum;
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(u) * 16;
        const int beside = (u + side) * kRowsTogether + g * B::kNum;
        const auto sums_of = [&](int r) { return group[r].sums + at; };
        const auto best = B::Best(hn::Load(d, states[side][g]), B::Next(shifts + beside), side == 1, v_p1,
                                  Replicate(d, B::Next(p2 + beside)));
        const auto value = hn::Add(B::Load([&](int r) { return group[r].costs + at; }), hn::Not(best));
        hn::Store(hn::Not(hn::Sub(value, MinimumOfBlocks(d, value))), d, states[side][g]);
        B::Store(hn::SaturatedAdd(value, B::Load(sums_of)), sums_of);
      }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#endif
