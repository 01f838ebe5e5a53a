// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Where surfaces are seen so flatly that their disparity changes by a good part of a pixel from row to row,
/// as on a tread a little below the eye: there neighbours are of one surface though their disparities differ.
class SteepSurfaces {
 public:
  /// @param disparity_px  not refined yet; NaN = unknown
  void Measure(const cv::Mat1f& disparity_px);

  /// How much the disparities change from row v to the next, in UnitImage's units; 0 where the surface is not
  /// steep, or ends. In an image `scale` times as large as the one measured, as the slope is the same.
  /// False: all are 0 and nothing is written. Else `width` is filled up to a multiple of 64.
  bool SlopesOfRow(int v, int scale, int width, std::int16_t* slopes) const;

 private:
  struct Line {
    float slope = 0.0f;  ///< [px per row]; 0: no line
    float misfit = 0.0f;
  };
  void MeasureColumn(int block);

  int rows_ = 0, blocks_ = 0;         ///< a block is some pixels of one row
  std::vector<float> means_;          ///< disparity of each, column by column; NaN = unknown
  std::vector<Line> lines_;           ///< through the means around each, column by column
  std::vector<std::int16_t> slopes_;  ///< row by row
  std::vector<std::uint8_t> any_;     ///< whether a row has any
};

/// Those of an image `scale` times as small as the one that is worked on; null: there are none.
struct Steepness {
  const SteepSurfaces* surfaces = nullptr;
  int scale = 1;
};

}  // namespace terrace
