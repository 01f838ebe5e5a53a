// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Disparities as whole numbers of 1/128 px, 0 where unknown: twice as many fit into a vector as floats, and
/// sums of whole numbers can be moved along without ever losing anything. What is known is at least 1 and
/// less than 255 px. Rows have a margin of unknown disparities on either side, which vectors may touch.
class UnitImage {
 public:
  static constexpr int kUnitsPerPx = 128;
  static constexpr int kMaxUnits = 255 * kUnitsPerPx;
  static constexpr int kMargin = 64;  ///< at least as much behind each row

  /// The content is unknown disparities when the size changes, else what it was.
  void Create(const cv::Size& size);
  /// By TBB's threads.
  void Set(const cv::Mat1f& disparity_px);

  cv::Size size() const { return size_; }
  std::int16_t* Row(int v) { return rows_[v] + kMargin; }
  const std::int16_t* Row(int v) const { return rows_[v] + kMargin; }
  /// NaN where unknown.
  float Px(int v, int u) const {
    const std::int16_t units = Row(v)[u];
    return units == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(units) / kUnitsPerPx;
  }

 private:
  cv::Size size_;
  cv::Mat_<std::int16_t> rows_;
};

/// One row of disparities, NaN = unknown.
void ToUnits(const float* disparity_px, int width, std::int16_t* units);

}  // namespace terrace
