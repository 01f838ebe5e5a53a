// SPDX-License-Identifier: BSD-3-Clause
// The paths through rows of pixels, for the files that Highway compiles once per target.
#if defined(TERRACE_STEREO_PATH_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRACE_STEREO_PATH_ROWS_INL_H_
#undef TERRACE_STEREO_PATH_ROWS_INL_H_
#else
#define TERRACE_STEREO_PATH_ROWS_INL_H_
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

/// L(p, d) = C(p, d) + min(L(q, d), L(q, d -+ 1) + P1, min L(q) + P2) - min L(q).
/// @tparam kVectors  that hold the disparities; 0: not known before
/// @param before  L(q, .), its index shifted to p's range
/// @return the least L of each lane, folded to 16 bytes.
template <int kVectors, class D, class CostOf, class Use>
HWY_INLINE hn::Vec<Tag16> Step(D d, int num_disparities, const std::uint8_t* HWY_RESTRICT before,
                               std::uint8_t* HWY_RESTRICT now, std::uint8_t p1, std::uint8_t p2,
                               std::uint8_t minimum, const CostOf& cost_of, const Use& use) {
  const auto v_p1 = hn::Set(d, p1);
  const auto v_minimum = hn::Set(d, minimum);
  const auto v_jump = hn::Set(d, static_cast<std::uint8_t>(minimum + p2));
  auto least = hn::Set(d, 255);
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  const int end = kVectors > 0 ? kVectors * kLanes : num_disparities;
  for (int k = 0; k < end; k += kLanes) {
    const auto beside = hn::Min(hn::LoadU(d, before + k - 1), hn::LoadU(d, before + k + 1));
    const auto best = hn::Min(hn::Min(hn::LoadU(d, before + k), hn::SaturatedAdd(beside, v_p1)), v_jump);
    const auto value = hn::Add(hn::Sub(best, v_minimum), cost_of(k));
    hn::Store(value, d, now + k);
    least = hn::Min(least, value);
    use(k, value);
  }
  return FoldTo16(d, least);
}

HWY_INLINE int Shift(int first_before, int first_now) {
  return std::clamp(first_before - first_now, -kMaxShift, kMaxShift);
}

template <class D>
HWY_INLINE hn::Vec<D> Hamming(D d, const hn::Vec<D>* left, const RowPointers& row, std::ptrdiff_t right_u) {
  static_assert(CensusImage::kNumPlanes == 4);
  const auto bits = [&](int p) HWY_ATTR {
    return hn::PopulationCount(hn::Xor(left[p], hn::LoadU(d, row.right[p] + right_u)));
  };
  auto cost = hn::Add(hn::Add(bits(0), bits(1)), hn::Add(bits(2), bits(3)));
  if (right_u < 0) {
    const std::ptrdiff_t num_outside = std::min<std::ptrdiff_t>(-right_u, static_cast<int>(hn::MaxLanes(d)));
    const auto outside = hn::Lt(hn::Iota(d, 0), hn::Set(d, static_cast<std::uint8_t>(num_outside)));
    const auto shown = hn::Add(hn::Add(hn::PopulationCount(left[0]), hn::PopulationCount(left[1])),
                               hn::Add(hn::PopulationCount(left[2]), hn::PopulationCount(left[3])));
    cost = hn::IfThenElse(outside, hn::Min(shown, hn::Set(d, kMaxCostOutside)), cost);
  }
  return cost;
}

/// The paths into one row from the row before.
template <int kVectors, bool kDiagonals, Sums kSums, class D>
void VerticalRow(D d, const RowPointers& row, int width, int n, std::uint8_t p1, const StripMemory& memory) {
  constexpr int kNumPaths = kDiagonals ? kMostFromRow : 1;
  for (int u0 = 0; u0 < width; u0 += kBlock) {
    hn::Vec<Tag16> least[kNumPaths][kBlock];
    for (int i = 0; i < kBlock; ++i) {
      const int u = u0 + i;
      const hn::Vec<D> words[] = {hn::Set(d, row.left[0][u]), hn::Set(d, row.left[1][u]),
                                  hn::Set(d, row.left[2][u]), hn::Set(d, row.left[3][u])};
      const std::ptrdiff_t right_u = u - (row.first[u] + n - 1);
      std::uint8_t* costs = row.costs + static_cast<std::ptrdiff_t>(u) * n;
      std::uint8_t* sums = row.sums + static_cast<std::ptrdiff_t>(u) * n;
      std::uint8_t* row_sums = memory.row_sums + static_cast<std::ptrdiff_t>(u) * n;
      const auto cost_of = [&](int k) HWY_ATTR {
        const auto cost = hn::Add(Hamming(d, words, row, right_u + k), hn::Load(d, row.prior_costs + k));
        if constexpr (kSums == Sums::kSet || kSums == Sums::kCosts || kDiagonals)
          hn::Store(cost, d, costs + k);
        return cost;
      };
      const auto use = [&](int k, hn::Vec<D> value) HWY_ATTR {
        if constexpr (kSums == Sums::kSet) hn::Store(value, d, sums + k);
        if constexpr (kSums == Sums::kAdd)
          hn::Store(hn::SaturatedAdd(value, hn::Load(d, sums + k)), d, row_sums + k);
      };
      if constexpr (kSums == Sums::kCosts) {
        for (int k = 0; k < n; k += static_cast<int>(hn::MaxLanes(d))) cost_of(k);
        continue;
      }
      const auto step = [&](int path, const auto& cost_of_step, const auto& use_step) HWY_ATTR {
        const int u_before = u + kFromColumn[path];
        const bool begins = path > 0 && (u_before < 0 || u_before >= width);
        const int shift = begins ? 0 : Shift(row.first_before[path][u], row.first[u]);
        const std::ptrdiff_t in_paths = path * memory.path_bytes, in_minima = path * memory.minima_bytes;
        least[path][i] =
            Step<kVectors>(d, n, memory.paths[0] + in_paths + u_before * memory.pixel_bytes + shift,
                           memory.paths[1] + in_paths + u * memory.pixel_bytes, p1, row.p2[path][u],
                           memory.minima[0][in_minima + u_before], cost_of_step, use_step);
      };
      if constexpr (kDiagonals) {
        HWY_ALIGN std::uint8_t diagonals[256];
        const auto kept_cost_of = [&](int k) HWY_ATTR { return hn::Load(d, costs + k); };
        step(1, cost_of, [&](int k, hn::Vec<D> value) HWY_ATTR { hn::Store(value, d, diagonals + k); });
        step(2, kept_cost_of, [&](int k, hn::Vec<D> value) HWY_ATTR {
          hn::Store(hn::AverageRound(value, hn::Load(d, diagonals + k)), d, diagonals + k);
        });
        step(0, kept_cost_of, [&](int k, hn::Vec<D> value) HWY_ATTR {
          use(k, hn::AverageRound(value, hn::Load(d, diagonals + k)));
        });
      } else {
        step(0, cost_of, use);
      }
    }
    if constexpr (kSums != Sums::kCosts)
      for (int path = 0; path < kNumPaths; ++path)
        hn::StoreU(MinimumOfEach(least[path]), Tag16(), memory.minima[1] + path * memory.minima_bytes + u0);
  }
}

/// The paths from the left and from the right through kRowsTogether rows in lockstep: the latency of a step
/// is hidden by the other rows'. `rows` may name one row more than once only if its result is not needed.
template <int kVectors, class D>
void HorizontalRows(D d, const RowPointers* rows, int width, int n, std::uint8_t p1) {
  constexpr int kNumPaths = 2 * kRowsTogether;
  constexpr int kPathBytes = kPathPadding + 256 + kPathPadding;
  HWY_ALIGN std::uint8_t paths[2][kNumPaths][kPathBytes];
  HWY_ALIGN std::uint8_t minima[kNumPaths] = {};
  std::memset(paths, 255, sizeof(paths));
  for (auto& path : paths[1]) std::memset(path + kPathPadding, 0, static_cast<std::size_t>(n));
  for (int i = 0; i < width; ++i) {
    hn::Vec<Tag16> least[kNumPaths];
    for (int r = 0; r < kRowsTogether; ++r)
      for (int side = 0; side < 2; ++side) {
        const RowPointers& row = rows[r];
        const int u = side == 0 ? i : width - 1 - i;
        const int u_before = std::clamp(side == 0 ? u - 1 : u + 1, 0, width - 1);
        const std::uint8_t* costs = row.costs + static_cast<std::ptrdiff_t>(u) * n;
        std::uint8_t* sums = row.sums + static_cast<std::ptrdiff_t>(u) * n;
        const auto cost_of = [&](int k) HWY_ATTR { return hn::Load(d, costs + k); };
        const auto use = [&](int k, hn::Vec<D> value) HWY_ATTR {
          hn::Store(hn::SaturatedAdd(value, hn::Load(d, sums + k)), d, sums + k);
        };
        const int path = 2 * r + side;
        least[path] = Step<kVectors>(
            d, n, paths[(i + 1) & 1][path] + kPathPadding + Shift(row.first[u_before], row.first[u]),
            paths[i & 1][path] + kPathPadding, p1, row.p2[0][u + side], minima[path], cost_of, use);
      }
    hn::Store(MinimumOfEach(least), Tag16(), minima);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#endif
