// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/image_pyramid.h"

#include <algorithm>
#include <cstdint>

#include <opencv2/imgproc.hpp>

namespace terrace {

ImagePyramid BuildPyramid(const cv::Mat1b& image) {
  ImagePyramid pyramid;
  pyramid.levels[0] = image;
  for (int l = 1; l < ImagePyramid::kNumLevels; ++l) cv::pyrDown(pyramid.levels[l - 1], pyramid.levels[l]);
  return pyramid;
}

double Sharpness(const ImagePyramid& image) {
  const auto Energy = [](const cv::Mat1b& level, int every_row) {
    std::int64_t sum = 0;
    std::int64_t count = 0;
    for (int v = 0; v + 1 < level.rows; v += every_row) {
      const std::uint8_t* row = level[v];
      const std::uint8_t* below = level[v + 1];
      std::int32_t of_row = 0;
      for (int u = 0; u + 1 < level.cols; ++u) {
        const int across = row[u + 1] - row[u];
        const int down = below[u] - row[u];
        of_row += across * across + down * down;
      }
      sum += of_row;
      count += level.cols - 1;
    }
    return static_cast<double>(sum) / static_cast<double>(std::max<std::int64_t>(count, 1));
  };
  constexpr int kEveryRow = 4;  // enough to know
  return Energy(image[0], kEveryRow) / std::max(Energy(image[2], 1), 1e-3);
}

}  // namespace terrace
