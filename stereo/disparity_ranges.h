// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Where each pixel's search range begins; disparities below 0 are searched, but never found. Rows are
/// continued to a multiple of 16 pixels, and by one on either side whose content means nothing.
class DisparityRanges {
 public:
  void Set(int width, int height, int first);
  void Set(const cv::Mat_<std::int16_t>& first);
  const std::int16_t* First(int v) const { return first_.data() + 1 + static_cast<std::size_t>(v) * width_; }
  int max_first() const { return max_first_; }
  bool uniform() const { return uniform_; }  ///< all ranges begin at the same disparity

 private:
  int width_ = 0;
  int max_first_ = 0;
  bool uniform_ = true;
  std::vector<std::int16_t> first_;
};

}  // namespace terrace
