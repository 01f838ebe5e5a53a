// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace terrace {

/// By how many rows further down the right image shows what the left one shows, where the pair is not
/// rectified exactly. A camera that is pitched shifts all rows alike, a rolled one shifts them the more the
/// further out the column is, another focal length the more the further up or down.
struct RowOffsets {
  float centre_px = 0.0f;  ///< in the middle of the right image
  float per_column = 0.0f;
  float per_row = 0.0f;
  float spread_px = 0.0f;  ///< median distance of single places from the three above
  int num_places = 0;      ///< that say so; 0: nothing is known

  /// @param x, y  from the middle of the right image
  float At(float x, float y) const { return centre_px + per_column * x + per_row * y; }
  /// Root mean square over an image of that size.
  float Rms(const cv::Size& size) const;
  /// The same of images so many times as large.
  RowOffsets Scaled(float scale) const;
};

/// How far up and down is looked, in pixels of the images given.
constexpr int kMaxRowOffset = 12;

/// Measures them from the images alone: places all over the left image are searched for in the right one,
/// over the disparities given and kMaxRowOffset rows up and down, found exactly by Lucas-Kanade steps in both
/// directions, and fitted robustly. Nothing is known where few places are found, or where they do not agree.
/// Both images are of equal size; brightness may differ.
RowOffsets MeasureRowOffsets(const cv::Mat1b& left, const cv::Mat1b& right, int num_disparities);

/// Moves the rows of a right image to where the left one has them, by a cubic.
void StraightenRows(const cv::Mat1b& right, const RowOffsets& offsets, cv::Mat1b& straight);

}  // namespace terrace
