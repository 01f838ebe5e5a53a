// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/image_pyramid.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "textured_image.h"

namespace terrace {
namespace {

TEST(ImagePyramidTest, SharpnessFallsWithBlurAndNotWithBrightness) {
  cv::Mat1b image(240, 320);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) image(v, u) = cv::saturate_cast<std::uint8_t>(Texture(4 * u, 4 * v));
  cv::Mat1b dark, blurred;
  image.convertTo(dark, -1, 0.5);
  cv::blur(image, blurred, {7, 7});
  const double sharpness = Sharpness(BuildPyramid(image));
  EXPECT_NEAR(Sharpness(BuildPyramid(dark)), sharpness, 0.05 * sharpness);
  EXPECT_LT(Sharpness(BuildPyramid(blurred)), 0.65 * sharpness);
}

TEST(ImagePyramidTest, AnImageWithoutAnythingInItIsNotSharp) {
  EXPECT_EQ(Sharpness(BuildPyramid(cv::Mat1b(240, 320, std::uint8_t{7}))), 0.0);
}

}  // namespace
}  // namespace terrace
