// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_ranges.h"

#include <algorithm>

#include "stereo/path_layout.h"

namespace terrace {

void DisparityRanges::Set(int width, int height, int first) {
  width_ = (width + kBlock - 1) / kBlock * kBlock;
  max_first_ = first;
  uniform_ = true;
  first_.assign(static_cast<std::size_t>(width_) * height + 2, static_cast<std::int16_t>(first));
}

void DisparityRanges::Set(const cv::Mat_<std::int16_t>& first) {
  width_ = (first.cols + kBlock - 1) / kBlock * kBlock;
  first_.resize(static_cast<std::size_t>(width_) * first.rows + 2);
  max_first_ = 0;
  uniform_ = false;
  for (int v = 0; v < first.rows; ++v) {
    std::int16_t* row = first_.data() + 1 + static_cast<std::size_t>(v) * width_;
    std::copy_n(first[v], first.cols, row);
    std::fill(row + first.cols, row + width_, row[first.cols - 1]);
    std::int16_t most = 0;
    for (int u = 0; u < first.cols; ++u) most = std::max(most, row[u]);
    max_first_ = std::max<int>(max_first_, most);
  }
}

}  // namespace terrace
