// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "stereo/census.h"
#include "stereo/path_aggregation.h"
#include "stereo/winner.h"

namespace terrace {

/// How one pair is matched.
struct SemiGlobalSettings {
  std::vector<CensusPair> census = Census9x7();
  PathPenalties penalties;
  WinnerRules winner;
  int rows_per_strip = 64;
  int lead_in = 16;
};

/// Semi-global matching of two images of equal size, by strips that TBB's threads share.
class SemiGlobalMatcher {
 public:
  explicit SemiGlobalMatcher(SemiGlobalSettings settings);
  ~SemiGlobalMatcher();

  /// Disparities 0 ... num_disparities - 1 of the left image's pixels; NaN = unknown.
  void Match(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities, cv::Mat1f& disparity);
  /// The same near a disparity that is known roughly for each pixel; known nowhere else. Small differences
  /// from it cost nothing against what the images say, but decide where they say nothing.
  void MatchNear(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& rough, cv::Mat1f& disparity);

 private:
  class Scratch;
  void MatchStrips(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities,
                   const std::uint8_t* prior_costs, cv::Mat1f& disparity);

  SemiGlobalSettings settings_;
  CensusImage left_census_, right_census_;
  StepPenalties step_penalties_;
  DisparityRanges ranges_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace terrace
