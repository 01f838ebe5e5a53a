// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/path_aggregation.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "core/check.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/path_aggregation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stereo/vector_minimum-inl.h"

#ifndef TERRACE_STEREO_PATH_AGGREGATION_ONCE_
#define TERRACE_STEREO_PATH_AGGREGATION_ONCE_
namespace terrace {

constexpr int kBlock = 16;        // pixels whose minima are found together
constexpr int kRowsTogether = 8;  // through which the horizontal paths run in lockstep

/// Bytes between the states of neighbouring pixels' paths. They hold 255, so that a disparity outside the
/// range is never the best neighbour.
constexpr int kPathPadding = 64;
/// Bytes before the first pixel of a row of paths, and behind the last: room for a pixel beside the image,
/// where diagonal paths begin.
constexpr int kPathMargin = kPathPadding + 256 + kPathPadding;
constexpr int kMinimaMargin = 64;
/// Where the ranges of neighbours differ they hold at most 32 disparities, so that ranges shifted by this
/// against each other do not touch: greater shifts are cut to it.
constexpr int kMaxRangeThatShifts = 32;
constexpr int kMaxShift = 33;

/// From which column, counted from its own, the paths come into a pixel from the row before: the vertical one
/// and the diagonal ones.
constexpr int kFromColumn[] = {0, -1, 1};
constexpr int kMostFromRow = 3;

/// Where the work on a strip goes on.
struct StripMemory {
  std::uint8_t* costs;        // of kRowsTogether rows
  std::uint8_t* sums;         // of all paths but those from above, of all rows of the strip and one more
  std::uint8_t* row_sums;     // of all paths, of one row
  std::uint8_t* paths[2];     // state of the paths from row to row: the row before and this one
  std::uint8_t* minima[2];    // of the same
  std::uint8_t *shifts, *p2;  // of ranges of 16: of kRowsTogether rows
  std::ptrdiff_t row_bytes;
  std::ptrdiff_t pixel_bytes;               // of the state of one path
  std::ptrdiff_t path_bytes, minima_bytes;  // from one path's row to the next one's: vertical, diagonal
  int padded_width;
};

/// In place of the number of vectors that hold the disparities of a pixel: one vector holds those of several.
constexpr int kOfBlocks = -1;

alignas(64) constexpr std::uint8_t kNoCosts[256] = {};

/// One row of the images and of the volumes.
struct RowPointers {
  const std::uint8_t* left[CensusImage::kNumPlanes];
  const std::uint8_t* right[CensusImage::kNumPlanes];
  const std::uint8_t* p2[kMostFromRow];            // of the horizontal paths only the first
  const std::int16_t* first;                       // disparity of each pixel's range
  const std::int16_t* first_before[kMostFromRow];  // the same of the pixel that the path comes from
  const std::uint8_t* prior_costs;
  std::uint8_t* costs;
  std::uint8_t* sums;
};

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Cost of a disparity that leads out of the right image: more than a good match has, less than a wrong one,
/// so that surfaces continue to where only the left camera sees them; such winners are thrown away. Less
/// where the left image shows nothing either: there it says nothing about where things are not.
constexpr std::uint8_t kMaxCostOutside = 10;

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

/// What becomes of the values of the paths from row to row, and of the costs, which are computed on the way.
enum class Sums {
  kNone,   // outside the strip: neither is kept
  kCosts,  // no such paths: the costs are stored
  kSet,    // the upward paths: both are stored
  kAdd,    // the downward paths: with the other paths' sums they give the row's
};

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

/// @tparam kVectors  that hold the disparities of a pixel; 0: not known before; kOfBlocks: several in one
/// vector
template <int kVectors, bool kDiagonals, class D>
void AggregateWith(D d, const MatchingProblem& problem, const Strip& strip,
                   const PathAggregator::UseRow& use_row, StripMemory memory) {
  constexpr bool kBlocks = kVectors == kOfBlocks;
  constexpr int kNumPaths = kDiagonals ? kMostFromRow : 1;
  const CensusImage& left = *problem.left;
  const CensusImage& right = *problem.right;
  const int width = left.width();
  const std::uint8_t p1 = static_cast<std::uint8_t>(problem.p1);
  const int n = strip.num_disparities;

  const auto row_of = [&](int v, int v_before) {
    RowPointers row;
    for (int p = 0; p < CensusImage::kNumPlanes; ++p)
      row.left[p] = left.Row(v, p), row.right[p] = right.Row(v, p);
    row.first = problem.ranges->First(v);
    for (int path = 0; path < kNumPaths; ++path) {
      const int du = kFromColumn[path];
      row.first_before[path] = v_before == v ? row.first : problem.ranges->First(v_before) + du;
      // A step up costs what the same step down does.
      row.p2[path] = v_before > v ? problem.step_penalties->FromAbove(v_before, -du) + du
                                  : problem.step_penalties->FromAbove(v, du);
    }
    row.prior_costs = problem.prior_costs ? problem.prior_costs : kNoCosts;
    const std::ptrdiff_t in_strip = std::clamp(v, strip.top, strip.bottom - 1) - strip.top;
    const std::ptrdiff_t in_costs = kBlocks ? in_strip : in_strip % kRowsTogether;
    row.costs = memory.costs + in_costs * memory.row_bytes;
    row.sums = memory.sums + in_strip * memory.row_bytes;
    return row;
  };
  const auto start_path = [&](std::uint8_t* path) { std::memset(path, kBlocks ? 255 : 0, n); };
  const auto start_paths = [&] {
    for (int side = 0; side < 2; ++side) {
      std::uint8_t* paths = memory.paths[side];
      std::memset(paths - kPathMargin, 255, kNumPaths * memory.path_bytes);
      for (int path = 0; path < kNumPaths && !kBlocks; ++path, paths += memory.path_bytes)
        for (int u = -1; u <= memory.padded_width; ++u) start_path(paths + u * memory.pixel_bytes);
      std::memset(memory.minima[side] - kMinimaMargin, 0, kNumPaths * memory.minima_bytes);
    }
  };
  const auto horizontal_paths = [&](int top) {
    RowPointers rows[kRowsTogether];
    for (int r = 0; r < kRowsTogether; ++r) {
      const int v = std::min(top + r, strip.bottom - 1);
      rows[r] = row_of(v, v);
      rows[r].p2[0] = problem.step_penalties->FromLeft(v);
      if (top + r >= strip.bottom)  // a row nobody reads, behind the strip's own
        rows[r].sums = memory.sums + (strip.bottom - strip.top) * memory.row_bytes;
    }
    if constexpr (kBlocks)
      HorizontalRowsOfBlocks(d, rows, width, p1, memory.shifts, memory.p2);
    else
      HorizontalRows<kVectors>(d, rows, width, n, p1);
  };
  const auto vertical_paths = [&](auto sums, const RowPointers& row) {
    if constexpr (kBlocks)
      VerticalRowOfBlocks<kDiagonals, sums.value>(d, row, width, p1, memory);
    else
      VerticalRow<kVectors, kDiagonals, sums.value>(d, row, width, n, p1, memory);
    if constexpr (kDiagonals) {  // the vectors ran on over the pixel behind the last, where a path begins
      start_path(memory.paths[1] + 2 * memory.path_bytes + width * memory.pixel_bytes);
      memory.minima[1][2 * memory.minima_bytes + width] = 0;
    }
    std::swap(memory.paths[0], memory.paths[1]);
    std::swap(memory.minima[0], memory.minima[1]);
  };
  constexpr std::integral_constant<Sums, Sums::kNone> kNone;
  constexpr std::integral_constant<Sums, Sums::kCosts> kCosts;
  constexpr std::integral_constant<Sums, Sums::kSet> kSet;
  constexpr std::integral_constant<Sums, Sums::kAdd> kAdd;

  if (problem.num_paths == 2) {
    for (int top = strip.top; top < strip.bottom; top += kRowsTogether) {
      const int bottom = std::min(top + kRowsTogether, strip.bottom);
      for (int v = top; v < bottom; ++v) {
        const RowPointers row = row_of(v, v);
        vertical_paths(kCosts, row);
        std::memset(row.sums, 0, memory.row_bytes);
      }
      horizontal_paths(top);
      for (int v = top; v < bottom; ++v) use_row(v, row_of(v, v).sums);
    }
    return;
  }
  start_paths();
  const int lowest = std::min(strip.bottom + strip.lead_in, left.height()) - 1;
  for (int v = lowest; v >= strip.top; --v) {
    const RowPointers row = row_of(v, std::min(v + 1, lowest));
    if (v >= strip.bottom)
      vertical_paths(kNone, row);
    else
      vertical_paths(kSet, row);
    // While costs and sums are still in the cache.
    if (v < strip.bottom && (v - strip.top) % kRowsTogether == 0) horizontal_paths(v);
  }
  start_paths();
  const int highest = std::max(strip.top - strip.lead_in, 0);
  for (int v = highest; v < strip.bottom; ++v) {
    const RowPointers row = row_of(v, std::max(v - 1, highest));
    if (v < strip.top)
      vertical_paths(kNone, row);
    else
      vertical_paths(kAdd, row);
    if (v >= strip.top) use_row(v, memory.row_sums);
  }
}

template <bool kDiagonals>
void AggregateBy(const MatchingProblem& problem, const Strip& strip, const PathAggregator::UseRow& use_row,
                 const StripMemory& memory) {
  // The widest vectors that the disparities of a pixel fill; the usual numbers of them without a loop.
  const int n = strip.num_disparities;
  const auto aggregate = [&](auto num_vectors, auto d) {
    AggregateWith<num_vectors.value, kDiagonals>(d, problem, strip, use_row, memory);
  };
  constexpr std::integral_constant<int, 0> kAny;
  constexpr std::integral_constant<int, 1> kOne;
  constexpr std::integral_constant<int, 2> kTwo;
  constexpr std::integral_constant<int, kOfBlocks> kBlocks;
  if (n % 64 == 0) {
    const ByteTag<64> d;
    const int num_vectors = n / static_cast<int>(hn::MaxLanes(d));
    if (num_vectors == 1) return aggregate(kOne, d);
    if (num_vectors == 2) return aggregate(kTwo, d);
    aggregate(kAny, d);
  } else if (n % 32 == 0) {
    const ByteTag<32> d;
    if (n == static_cast<int>(hn::MaxLanes(d))) return aggregate(kOne, d);
    aggregate(kAny, d);
  } else if (n == 16) {
    aggregate(kBlocks, ByteTag<64>());
  } else {
    aggregate(kAny, ByteTag<16>());
  }
}

void AggregateStrip(const MatchingProblem& problem, const Strip& strip, const PathAggregator::UseRow& use_row,
                    const StripMemory& memory) {
  if (problem.num_paths == 8)
    AggregateBy<true>(problem, strip, use_row, memory);
  else
    AggregateBy<false>(problem, strip, use_row, memory);
}

void StepPenaltyRow(const std::uint8_t* pixel, const std::uint8_t* neighbour, int width, std::uint8_t p2_max,
                    std::uint8_t p2_min, std::uint8_t* p2) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto most = hn::Set(d, p2_max), least = hn::Set(d, p2_min);
  const auto store = [&](int u) HWY_ATTR {
    const auto a = hn::LoadU(d, pixel + u), b = hn::LoadU(d, neighbour + u);
    const auto difference = hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a));
    hn::StoreU(hn::Max(least, hn::SaturatedSub(most, difference)), d, p2 + u);
  };
  int u = 0;
  for (; u + lanes <= width; u += lanes) store(u);
  for (; u < width; ++u) {
    const int difference = pixel[u] > neighbour[u] ? pixel[u] - neighbour[u] : neighbour[u] - pixel[u];
    p2[u] = static_cast<std::uint8_t>(std::max<int>(p2_min, p2_max - difference));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(AggregateStrip);
HWY_EXPORT(StepPenaltyRow);

/// Where a step comes from, by kind.
constexpr struct { int du, dv; } kFrom[] = {{-1, 0}, {0, -1}, {-1, -1}, {1, -1}};

void StepPenalties::Compute(const cv::Mat1b& image, const PathPenalties& penalties, bool diagonals) {
  TERRACE_CHECK(0 <= penalties.p1 && penalties.p1 <= penalties.p2_min &&
                    penalties.p2_min <= penalties.p2_max && penalties.p2_max <= 50,
                penalties.p1, penalties.p2_min, penalties.p2_max);
  stride_ = static_cast<std::size_t>((image.cols + 1 + 63) / 64 * 64);
  num_kinds_ = diagonals ? 4 : 2;
  bytes_.Reserve(num_kinds_ * stride_ * image.rows + kBlock);  // vectors read on behind the last
  const std::uint8_t p2_max = static_cast<std::uint8_t>(penalties.p2_max);
  const std::uint8_t p2_min = static_cast<std::uint8_t>(penalties.p2_min);
  for (int v = 0; v < image.rows; ++v)
    for (int kind = 0; kind < num_kinds_; ++kind) {
      const auto [du, dv] = kFrom[kind];
      const std::uint8_t* neighbours = image[std::max(v + dv, 0)];
      std::uint8_t* p2 = bytes_.data() + (static_cast<std::size_t>(v) * num_kinds_ + kind) * stride_;
      // No step comes from outside; the paths from row to row run on to a multiple of 16 pixels.
      const int begin = std::max(-du, 0), end = image.cols - std::max(du, 0);
      std::memset(p2, p2_max, begin);
      std::memset(p2 + end, p2_max, stride_ - end);
      HWY_DYNAMIC_DISPATCH(StepPenaltyRow)
      (image[v] + begin, neighbours + begin + du, end - begin, p2_max, p2_min, p2 + begin);
    }
}

void DisparityRanges::Set(int width, int height, int first) {
  width_ = (width + kBlock - 1) / kBlock * kBlock;
  max_first_ = first;
  uniform_ = true;
  first_.assign(static_cast<std::size_t>(width_) * height + 2, static_cast<std::int16_t>(first));
}

void DisparityRanges::Set(const cv::Mat_<std::int16_t>& first) {
  width_ = (first.cols + kBlock - 1) / kBlock * kBlock;
  first_.resize(static_cast<std::size_t>(width_) * first.rows + 2);
  max_first_ = 0;
  uniform_ = false;
  for (int v = 0; v < first.rows; ++v) {
    std::int16_t* row = first_.data() + 1 + static_cast<std::size_t>(v) * width_;
    std::copy_n(first[v], first.cols, row);
    std::fill(row + first.cols, row + width_, row[first.cols - 1]);
    std::int16_t most = 0;
    for (int u = 0; u < first.cols; ++u) most = std::max(most, row[u]);
    max_first_ = std::max<int>(max_first_, most);
  }
}

void PathAggregator::Aggregate(const MatchingProblem& problem, const Strip& strip, const UseRow& use_row) {
  const CensusImage& left = *problem.left;
  TERRACE_CHECK(left.width() == problem.right->width() && left.height() == problem.right->height());
  TERRACE_CHECK(strip.num_disparities % 16 == 0 && strip.num_disparities >= 16, strip.num_disparities);
  TERRACE_CHECK(problem.ranges->max_first() + strip.num_disparities <= 256 + 16, problem.ranges->max_first());
  TERRACE_CHECK(problem.ranges->uniform() || strip.num_disparities <= kMaxRangeThatShifts,
                strip.num_disparities);
  TERRACE_CHECK(problem.num_paths == 2 || problem.num_paths == 4 || problem.num_paths == 8,
                problem.num_paths);
  TERRACE_CHECK(0 <= strip.top && strip.top < strip.bottom && strip.bottom <= left.height());
  const std::size_t padded_width = static_cast<std::size_t>((left.width() + kBlock - 1) / kBlock * kBlock);
  const std::size_t row_bytes = padded_width * strip.num_disparities;
  const std::size_t num_rows = static_cast<std::size_t>(strip.bottom - strip.top);
  const std::size_t pixel_bytes = strip.num_disparities + (strip.num_disparities == 16 ? 0 : kPathPadding);
  const std::size_t path_bytes = 2 * kPathMargin + padded_width * pixel_bytes;
  const std::size_t minima_bytes = 2 * kMinimaMargin + padded_width;
  const std::size_t num_from_row = problem.num_paths == 8 ? kMostFromRow : 1;
  StripMemory memory;
  // Those of 16 disparities stay in the cache as they are, others are computed twice.
  memory.costs = costs_.Reserve((strip.num_disparities == 16 ? num_rows : kRowsTogether) * row_bytes);
  memory.sums = sums_.Reserve((num_rows + 1) * row_bytes);
  memory.paths[0] = paths_.Reserve(2 * num_from_row * path_bytes) + kPathMargin;
  memory.paths[1] = memory.paths[0] + num_from_row * path_bytes;
  memory.minima[0] = path_minima_.Reserve(2 * num_from_row * minima_bytes) + kMinimaMargin;
  memory.minima[1] = memory.minima[0] + num_from_row * minima_bytes;
  memory.row_sums = row_sums_.Reserve(row_bytes);
  const std::size_t step_bytes = kRowsTogether * (padded_width + 1);
  memory.shifts = steps_.Reserve(2 * (step_bytes + kRowsTogether));
  memory.p2 = memory.shifts + step_bytes + kRowsTogether;
  memory.row_bytes = static_cast<std::ptrdiff_t>(row_bytes);
  memory.pixel_bytes = static_cast<std::ptrdiff_t>(pixel_bytes);
  memory.path_bytes = static_cast<std::ptrdiff_t>(path_bytes);
  memory.minima_bytes = static_cast<std::ptrdiff_t>(minima_bytes);
  memory.padded_width = static_cast<int>(padded_width);
  HWY_DYNAMIC_DISPATCH(AggregateStrip)(problem, strip, use_row, memory);
}

}  // namespace terrace
#endif  // HWY_ONCE
