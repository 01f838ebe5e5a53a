// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include "stereo/aligned_array.h"
#include "stereo/census.h"
#include "stereo/disparity_ranges.h"
#include "stereo/step_penalties.h"

namespace terrace {

/// What all strips of an image share.
struct MatchingProblem {
  const CensusImage* left = nullptr;
  const CensusImage* right = nullptr;
  const DisparityRanges* ranges = nullptr;
  const StepPenalties* step_penalties = nullptr;
  int p1 = 6;
  /// Added to the costs of each pixel's disparities, the largest first: what is known against them. Aligned
  /// like vectors, at most 10 each; null: nothing.
  const std::uint8_t* prior_costs = nullptr;
  int num_paths = 4;  ///< 2, 4 or 8
};

/// Rows [top, bottom) of the image.
struct Strip {
  int top = 0, bottom = 0;
  int lead_in = 16;           ///< rows above and below from which the vertical paths come
  int num_disparities = 128;  ///< from the first of each pixel's range on; a multiple of 16, at most 256
};

/// Costs of a strip, summed over paths: two, from the left and the right; four, from above and below, too; or
/// eight, where the mean of the two diagonal paths from above, averaged with the vertical one, stands for it,
/// and the same from below. With the diagonal paths in full, neighbours in the row would have no more than a
/// quarter of the say, which is worse than four paths almost everywhere.
///
/// Everything is 8 bits wide. A census cost is at most 32, with what is known beforehand 42; a path's value
/// is at most its cost + P2, since the minimum over the disparities is taken off in each step: <= 42 + 50 =
/// 92, so that no path overflows. Averages of paths, rounded up, are not above the greatest of them. The sum
/// of two is at most 184; that of four, or of two and two averages, may overflow where it is far from any
/// good match: it saturates at 255, and a pixel whose best sum is 255 is unknown.
class PathAggregator {
 public:
  /// Gets the sums of row v, from top to bottom: num_disparities bytes for each pixel, the largest disparity
  /// first.
  using UseRow = std::function<void(int v, const std::uint8_t* sums)>;

  void Aggregate(const MatchingProblem& problem, const Strip& strip, const UseRow& use_row);

 private:
  AlignedArray<std::uint8_t> costs_, sums_, row_sums_, paths_, path_minima_, steps_;
};

}  // namespace terrace
