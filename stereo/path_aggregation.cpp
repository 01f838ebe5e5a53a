// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/path_aggregation.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

#include "core/check.h"
#include "stereo/path_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/path_aggregation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stereo/path_blocks-inl.h"
#include "stereo/path_rows-inl.h"
#include "stereo/vector_minimum-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The work on one strip.
/// @tparam kVectors  that hold the disparities of a pixel; 0: not known before; kOfBlocks: several in one
/// vector
template <int kVectors, bool kDiagonals, class D>
class StripAggregation {
 public:
  StripAggregation(const MatchingProblem& problem, const Strip& strip, const PathAggregator::UseRow& use_row,
                   const StripMemory& memory)
      : problem_(problem),
        strip_(strip),
        use_row_(use_row),
        memory_(memory),
        width_(problem.left->width()),
        p1_(static_cast<std::uint8_t>(problem.p1)) {}

  void FromTheSidesOnly() {
    for (int top = strip_.top; top < strip_.bottom; top += kRowsTogether) {
      const int bottom = std::min(top + kRowsTogether, strip_.bottom);
      for (int v = top; v < bottom; ++v) {
        const RowPointers row = RowOf(v, v);
        VerticalPaths<Sums::kCosts>(row);
        std::memset(row.sums, 0, memory_.row_bytes);
      }
      HorizontalPaths(top);
      for (int v = top; v < bottom; ++v) use_row_(v, RowOf(v, v).sums);
    }
  }

  void UpwardsAndFromTheSides() {
    StartPaths();
    const int lowest = std::min(strip_.bottom + strip_.lead_in, problem_.left->height()) - 1;
    for (int v = lowest; v >= strip_.top; --v) {
      const RowPointers row = RowOf(v, std::min(v + 1, lowest));
      if (v >= strip_.bottom)
        VerticalPaths<Sums::kNone>(row);
      else
        VerticalPaths<Sums::kSet>(row);
      // While costs and sums are still in the cache.
      if (v < strip_.bottom && (v - strip_.top) % kRowsTogether == 0) HorizontalPaths(v);
    }
  }

  void Downwards() {
    StartPaths();
    const int highest = std::max(strip_.top - strip_.lead_in, 0);
    for (int v = highest; v < strip_.bottom; ++v) {
      const RowPointers row = RowOf(v, std::max(v - 1, highest));
      if (v < strip_.top)
        VerticalPaths<Sums::kNone>(row);
      else
        VerticalPaths<Sums::kAdd>(row);
      if (v >= strip_.top) use_row_(v, memory_.row_sums);
    }
  }

 private:
  static constexpr bool kBlocks = kVectors == kOfBlocks;
  static constexpr int kNumPaths = kDiagonals ? kMostFromRow : 1;

  RowPointers RowOf(int v, int v_before) const {
    RowPointers row;
    for (int p = 0; p < CensusImage::kNumPlanes; ++p)
      row.left[p] = problem_.left->Row(v, p), row.right[p] = problem_.right->Row(v, p);
    row.first = problem_.ranges->First(v);
    for (int path = 0; path < kNumPaths; ++path) {
      const int du = kFromColumn[path];
      row.first_before[path] = v_before == v ? row.first : problem_.ranges->First(v_before) + du;
      // A step up costs what the same step down does.
      row.p2[path] = v_before > v ? problem_.step_penalties->FromAbove(v_before, -du) + du
                                  : problem_.step_penalties->FromAbove(v, du);
    }
    row.prior_costs = problem_.prior_costs ? problem_.prior_costs : kNoCosts;
    const std::ptrdiff_t in_strip = std::clamp(v, strip_.top, strip_.bottom - 1) - strip_.top;
    const std::ptrdiff_t in_costs = kBlocks ? in_strip : in_strip % kRowsTogether;
    row.costs = memory_.costs + in_costs * memory_.row_bytes;
    row.sums = memory_.sums + in_strip * memory_.row_bytes;
    return row;
  }

  void StartPath(std::uint8_t* path) const { std::memset(path, kBlocks ? 255 : 0, strip_.num_disparities); }

  void StartPaths() const {
    for (int side = 0; side < 2; ++side) {
      std::uint8_t* paths = memory_.paths[side];
      std::memset(paths - kPathMargin, 255, kNumPaths * memory_.path_bytes);
      for (int path = 0; path < kNumPaths && !kBlocks; ++path, paths += memory_.path_bytes)
        for (int u = -1; u <= memory_.padded_width; ++u) StartPath(paths + u * memory_.pixel_bytes);
      std::memset(memory_.minima[side] - kMinimaMargin, 0, kNumPaths * memory_.minima_bytes);
    }
  }

  void HorizontalPaths(int top) const {
    RowPointers rows[kRowsTogether];
    for (int r = 0; r < kRowsTogether; ++r) {
      const int v = std::min(top + r, strip_.bottom - 1);
      rows[r] = RowOf(v, v);
      rows[r].p2[0] = problem_.step_penalties->FromLeft(v);
      if (top + r >= strip_.bottom)  // a row nobody reads, behind the strip's own
        rows[r].sums = memory_.sums + (strip_.bottom - strip_.top) * memory_.row_bytes;
    }
    if constexpr (kBlocks)
      HorizontalRowsOfBlocks(D(), rows, width_, p1_, memory_.shifts, memory_.p2);
    else
      HorizontalRows<kVectors>(D(), rows, width_, strip_.num_disparities, p1_);
  }

  template <Sums kSums>
  void VerticalPaths(const RowPointers& row) {
    if constexpr (kBlocks)
      VerticalRowOfBlocks<kDiagonals, kSums>(D(), row, width_, p1_, memory_);
    else
      VerticalRow<kVectors, kDiagonals, kSums>(D(), row, width_, strip_.num_disparities, p1_, memory_);
    if constexpr (kDiagonals) {  // the vectors ran on over the pixel behind the last, where a path begins
      StartPath(memory_.paths[1] + 2 * memory_.path_bytes + width_ * memory_.pixel_bytes);
      memory_.minima[1][2 * memory_.minima_bytes + width_] = 0;
    }
    std::swap(memory_.paths[0], memory_.paths[1]);
    std::swap(memory_.minima[0], memory_.minima[1]);
  }

  const MatchingProblem& problem_;
  const Strip& strip_;
  const PathAggregator::UseRow& use_row_;
  StripMemory memory_;
  const int width_;
  const std::uint8_t p1_;
};

template <int kVectors, bool kDiagonals, class D>
void AggregateWith(D, const MatchingProblem& problem, const Strip& strip,
                   const PathAggregator::UseRow& use_row, const StripMemory& memory) {
  StripAggregation<kVectors, kDiagonals, D> aggregation(problem, strip, use_row, memory);
  if (problem.num_paths == 2) {
    aggregation.FromTheSidesOnly();
  } else {
    aggregation.UpwardsAndFromTheSides();
    aggregation.Downwards();
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

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(AggregateStrip);

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
