// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "stereo/census.h"
#include "stereo/doubtful_tiles.h"
#include "stereo/path_aggregation.h"
#include "stereo/winner.h"

namespace terrace {

/// How one pair is matched.
struct SemiGlobalSettings {
  std::vector<CensusPair> census = Census9x7();
  PathPenalties penalties;
  int num_paths = 4;  ///< 2, 4 or 8
  WinnerRules winner;
  int rows_per_strip = 64;
  int lead_in = 16;
};

/// Disparities from `first` on, `count` of them; both multiples of 16.
struct SearchRange {
  int first = 0;
  int count = 0;
};

/// What is known of an image before it is matched.
struct ExpectedDisparities {
  std::vector<SearchRange> strips;  ///< where to look first, for each strip of rows; empty: nothing is known
  int tile_px = 16;                 ///< rows_per_strip is a multiple of it
  int columns = 0;                  ///< of tiles
  std::vector<std::uint8_t>
      known;  ///< for each tile, row-major: most of its pixels should find a match there
};

/// Semi-global matching of two images of equal size, by strips that TBB's threads share.
class SemiGlobalMatcher {
 public:
  explicit SemiGlobalMatcher(SemiGlobalSettings settings);
  ~SemiGlobalMatcher();

  /// Disparities 0 ... num_disparities - 1 of the left image's pixels; NaN = unknown.
  /// A strip in which what is expected is not found is searched from end to end.
  void Match(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities, cv::Mat1f& disparity,
             const ExpectedDisparities& expected = {});
  /// The same near a disparity that is known roughly for each pixel; known nowhere else. Small differences
  /// from it cost nothing against what the images say, but decide where they say nothing.
  void MatchNear(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& rough, cv::Mat1f& disparity);

  /// Of the last Match, in the strips that were searched from end to end.
  DoubtfulTiles& doubtful() { return doubtful_; }

  int rows_per_strip() const { return settings_.rows_per_strip; }

 private:
  class Scratch;
  class Evidence;
  void Prepare(const cv::Mat1b& left, const cv::Mat1b& right);
  void PrepareRanges(const cv::Size& size, const std::vector<SearchRange>& strips);
  /// Calls work(strip) for all of them.
  template <typename Work>
  void ForEachStrip(int height, const Work& work) const;
  void MatchStrip(const Strip& strip, const DisparityRanges& ranges, const std::uint8_t* prior_costs,
                  Evidence* evidence, cv::Mat1f& disparity);

  SemiGlobalSettings settings_;
  CensusImage left_census_, right_census_;
  StepPenalties step_penalties_;
  DoubtfulTiles doubtful_;
  cv::Mat_<std::int16_t> near_first_;  ///< disparity of each pixel's range
  DisparityRanges near_ranges_;
  cv::Size ranges_size_;
  std::vector<DisparityRanges> ranges_;  // the same for all pixels: those that begin at 0, 16, 32 ...
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace terrace
