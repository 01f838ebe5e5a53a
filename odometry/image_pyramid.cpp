// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/image_pyramid.h"

#include <opencv2/imgproc.hpp>

namespace terrace {

ImagePyramid BuildPyramid(const cv::Mat1b& image) {
  ImagePyramid pyramid;
  pyramid.levels[0] = image;
  for (int l = 1; l < ImagePyramid::kNumLevels; ++l) cv::pyrDown(pyramid.levels[l - 1], pyramid.levels[l]);
  return pyramid;
}

}  // namespace terrace
