// SPDX-License-Identifier: BSD-3-Clause
// Minima over the disparities of sixteen pixels at once, for the files that Highway compiles once per target.
#if defined(TERRACE_STEREO_VECTOR_MINIMUM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRACE_STEREO_VECTOR_MINIMUM_INL_H_
#undef TERRACE_STEREO_VECTOR_MINIMUM_INL_H_
#else
#define TERRACE_STEREO_VECTOR_MINIMUM_INL_H_
#endif

#include <cstdint>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag16 = hn::FixedTag<std::uint8_t, 16>;

/// The widest vector of at most `bytes` bytes.
template <std::size_t bytes>
using ByteTag = hn::CappedTag<std::uint8_t, bytes>;

/// Halves a vector by minima until 16 bytes are left.
template <class D, class V>
HWY_INLINE hn::Vec<Tag16> FoldTo16(D d, V v) {
  if constexpr (hn::MaxLanes(d) == 16) {
    return v;
  } else {
    const hn::Half<D> half;
    return FoldTo16(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

/// Lane i is the least byte of v[i].
HWY_INLINE hn::Vec<Tag16> MinimumOfEach(const hn::Vec<Tag16>* v) {
  const Tag16 d8;
  const hn::Repartition<std::uint16_t, Tag16> d16;
  const hn::Repartition<std::uint32_t, Tag16> d32;
  const hn::Repartition<std::uint64_t, Tag16> d64;
  hn::Vec<Tag16> by2[8], by4[4], by8[2];
  for (int i = 0; i < 8; ++i)
    by2[i] = hn::Min(hn::InterleaveLower(d8, v[2 * i], v[2 * i + 1]),
                     hn::InterleaveUpper(d8, v[2 * i], v[2 * i + 1]));
  for (int i = 0; i < 4; ++i) {
    const auto a = hn::BitCast(d16, by2[2 * i]), b = hn::BitCast(d16, by2[2 * i + 1]);
    by4[i] = hn::Min(hn::BitCast(d8, hn::InterleaveLower(d16, a, b)),
                     hn::BitCast(d8, hn::InterleaveUpper(d16, a, b)));
  }
  for (int i = 0; i < 2; ++i) {
    const auto a = hn::BitCast(d32, by4[2 * i]), b = hn::BitCast(d32, by4[2 * i + 1]);
    by8[i] = hn::Min(hn::BitCast(d8, hn::InterleaveLower(d32, a, b)),
                     hn::BitCast(d8, hn::InterleaveUpper(d32, a, b)));
  }
  const auto a = hn::BitCast(d64, by8[0]), b = hn::BitCast(d64, by8[1]);
  return hn::Min(hn::BitCast(d8, hn::InterleaveLower(d64, a, b)),
                 hn::BitCast(d8, hn::InterleaveUpper(d64, a, b)));
}

/// Blocks are the parts of 16 bytes of a vector. All bytes of block i are the i-th of `bytes`.
template <class D>
HWY_INLINE hn::Vec<D> Replicate(D d, std::uint32_t bytes) {
  const hn::Repartition<std::uint32_t, D> d32;
  HWY_ALIGN static constexpr std::uint8_t kIndices[64] = {
      0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
      2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3};
  return hn::TableLookupBytes(hn::BitCast(d, hn::Set(d32, bytes)), hn::Load(d, kIndices));
}

/// The least byte of each block, in all of its bytes.
template <class D>
HWY_INLINE hn::Vec<D> MinimumOfBlocks(D d, hn::Vec<D> v) {
  HWY_ALIGN static constexpr std::uint8_t kBy[4][16] = {
      {8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7},
      {4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3},
      {2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1},
      {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0}};
  for (const auto& by : kBy) v = hn::Min(v, hn::TableLookupBytes(v, hn::LoadDup128(d, by)));
  return v;
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#endif
