// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <opencv2/core/mat.hpp>

#include "stereo/disparity_units.h"
#include "stereo/steep_surfaces.h"

namespace terrace {

struct RefineLimits;

/// Settings of the intensity-based sub-pixel step.
struct RefinementSettings {
  int iterations = 2;
  float max_step_px = 1.0f;      ///< a pixel that wants to go further in one iteration stays where it was
  float max_jump_px = 1.0f;      ///< neighbours whose disparity differs more belong to another surface
  float given_sigma_px = 0.15f;  ///< how far the disparity given is trusted where there is no texture
};

/// Moves each disparity to where the 5x5 windows of the two images agree best: a Lucas-Kanade step (1981)
/// along the row. Brightness differences cancel out: the gain of the whole pair is measured, the offset of
/// each window removed. The window follows the surface, since each of its pixels is taken at its own
/// disparity, and stops at depth edges: at neighbours that differ by more than the surface's own slope
/// explains.
class Refiner {
 public:
  explicit Refiner(const RefinementSettings& settings);
  ~Refiner();

  /// @param disparity  in: right to about a pixel, NaN where unknown; out: refined.
  /// @param sigma      out: standard deviation [px] from texture and residual, NaN where unknown. Null: not
  /// wanted.
  void Refine(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity, cv::Mat1f* sigma,
              const Steepness& steepness = {});
  /// @param given  in: disparities; out: anything
  void Refine(const cv::Mat1b& left, const cv::Mat1b& right, UnitImage& given, cv::Mat1f& disparity,
              cv::Mat1f* sigma, const Steepness& steepness = {});

 private:
  class StripRows;
  class Scratch;
  void RefineStrip(int top, int bottom, const RefineLimits& limits, const UnitImage& given,
                   const Steepness& steepness, cv::Mat1f* disparity, cv::Mat1f* sigma);

  RefinementSettings settings_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace terrace
