// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/disparity_picture.h"

#include <limits>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(DisparityPictureTest, ShowsDisparitiesBesideTheirErrors) {
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  FloatImage disparity_px(5, 1);
  DisparityTruth truth{FloatImage(5, 1), std::vector<PixelTruth>(5, PixelTruth::kVisible)};
  disparity_px.data = {20.0F, 11.0F, unknown, 25.0F, 10.0F};
  truth.disparity_px.data = {20.0F, 10.0F, 10.0F, 20.0F, 15.0F};
  truth.pixels[4] = PixelTruth::kHidden;
  const GrayImage picture = PictureOfErrors(disparity_px, truth);
  ASSERT_EQ(picture.width, 10);
  ASSERT_EQ(picture.height, 1);
  EXPECT_EQ(picture.data, (std::vector<std::uint8_t>{255, 140, 0, 255, 127,  //
                                                     0, 100, 255, 255, 0}));
}

TEST(DisparityPictureTest, EmbedsAPictureInAPage) {
  GrayImage image{16, 8, std::vector<std::uint8_t>(16 * 8, 77)};
  const std::string element = EmbeddedImage(image, "a < b");
  EXPECT_EQ(element.rfind("<img alt=\"a &lt; b\" src=\"data:image/jpeg;base64,/9j/", 0), 0U);
  EXPECT_EQ(element.find('\0'), std::string::npos);
  EXPECT_EQ(element.substr(element.size() - 2), "\">");
}

}  // namespace
}  // namespace terrace
