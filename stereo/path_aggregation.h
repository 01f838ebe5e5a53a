// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "stereo/aligned_array.h"
#include "stereo/census.h"

namespace terrace {

/// Penalties of the semi-global energy (Hirschmueller 2008), in bits of the census.
struct PathPenalties {
  int p1 = 6;       ///< for a change of disparity by one
  int p2_max = 40;  ///< for any other change, where the image is flat
  int p2_min = 16;  ///< the same across an edge of the image
};

/// The penalty P2 of stepping between neighbours: p2_max less the difference of their brightness.
class StepPenalties {
 public:
  void Compute(const cv::Mat1b& image, const PathPenalties& penalties);
  /// Of the step from (u - 1, v) to (u, v).
  const std::uint8_t* FromLeft(int v) const {
    return bytes_.data() + (2 * static_cast<std::size_t>(v)) * stride_;
  }
  /// Of the step from (u, v - 1) to (u, v).
  const std::uint8_t* FromAbove(int v) const {
    return bytes_.data() + (2 * static_cast<std::size_t>(v) + 1) * stride_;
  }

 private:
  std::size_t stride_ = 0;
  AlignedArray<std::uint8_t> bytes_;
};

/// Where each pixel's search range begins; disparities below 0 are searched, but never found. Rows are
/// continued to a multiple of 16 pixels.
class DisparityRanges {
 public:
  void Set(int width, int height, int first);
  void Set(const cv::Mat_<std::int16_t>& first);
  const std::int16_t* First(int v) const { return first_.data() + static_cast<std::size_t>(v) * width_; }
  int max_first() const { return max_first_; }
  bool uniform() const { return uniform_; }  ///< all ranges begin at the same disparity

 private:
  int width_ = 0;
  int max_first_ = 0;
  bool uniform_ = true;
  std::vector<std::int16_t> first_;
};

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
};

/// Rows [top, bottom) of the image.
struct Strip {
  int top = 0, bottom = 0;
  int lead_in = 16;           ///< rows above and below from which the vertical paths come
  int num_disparities = 128;  ///< from the first of each pixel's range on; a multiple of 16, at most 256
};

/// Costs of a strip, summed over four paths: from the left, the right, above and below.
///
/// Everything is 8 bits wide. A census cost is at most 32, with what is known beforehand 42; a path's value
/// is at most its cost + P2, since the minimum over the disparities is taken off in each step: <= 42 + 50 =
/// 92, so that no path overflows. The sum of four may, where it is far from any good match: it saturates at
/// 255, and a pixel whose best sum is 255 is unknown.
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
