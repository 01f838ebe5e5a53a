// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// An image and its halvings. Pixel (u, v) of level 0 lies at (u, v) / 2^l on level l.
struct ImagePyramid {
  static constexpr int kNumLevels = 4;
  std::array<cv::Mat1b, kNumLevels> levels;

  const cv::Mat1b& operator[](int level) const { return levels[level]; }
};

/// Level 0 shares the pixels of the image.
ImagePyramid BuildPyramid(const cv::Mat1b& image);

/// Energy of gradients between neighbours on level 0, over that on level 2: falls to half and less when the
/// image is blurred, whatever it shows and however bright it is.
double Sharpness(const ImagePyramid& image);

}  // namespace terrace
