// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/check.h"
#include "stereo/cloud.h"

namespace terrace {
namespace {

const StereoCamera kTinyCamera{64, 48, 40, 40, 31.5, 23.5, 0.12};

/// What the camera sees of the plane normal . p = offset (exact disparities), sigma 0.1 px everywhere.
DisparityImage SeePlane(const Eigen::Vector3d& normal_left, double offset_m) {
  DisparityImage image;
  image.disparity_px.create(kTinyCamera.height, kTinyCamera.width);
  image.sigma_px.create(kTinyCamera.height, kTinyCamera.width);
  for (int v = 0; v < kTinyCamera.height; ++v)
    for (int u = 0; u < kTinyCamera.width; ++u) {
      const Eigen::Vector3d ray((u - kTinyCamera.cx) / kTinyCamera.fx, (v - kTinyCamera.cy) / kTinyCamera.fy,
                                1.0);
      image.disparity_px(v, u) = static_cast<float>(kTinyCamera.Disparity(offset_m / normal_left.dot(ray)));
      image.sigma_px(v, u) = 0.1f;
    }
  return image;
}

CloudConfig EveryPixel() { return {.max_depth_sigma_m = 1e9, .min_spacing_m = 0.0}; }

TEST(TriangulateTest, RecoversAPlaneAtTwoMetresWithinOneMillimetre) {
  const Eigen::Vector3d normal_left = Eigen::Vector3d(0.1, 0.4, 1.0).normalized();
  const DisparityImage image = SeePlane(normal_left, 2.0);
  const Cloud cloud = Triangulate(image, kTinyCamera, EveryPixel());
  ASSERT_EQ(cloud.points.size(), 64u * 48u / 2u);
  for (const CloudPoint& point : cloud.points) {
    EXPECT_NEAR(normal_left.dot(point.p_left.cast<double>()), 2.0, 1e-3);
    const Eigen::Vector2d pixel = kTinyCamera.Project(point.p_left.cast<double>());
    EXPECT_NEAR(pixel.x(), point.u, 1e-3);
    EXPECT_NEAR(pixel.y(), point.v, 1e-3);
  }
}

TEST(TriangulateTest, GivesTheSigmaOfTheCameraModel) {
  const DisparityImage image = SeePlane(Eigen::Vector3d::UnitZ(), 2.0);
  const CloudPoint point = Triangulate(image, kTinyCamera, EveryPixel()).points.front();
  EXPECT_NEAR(point.sigma_depth_m, kTinyCamera.DepthSigma(2.0, 0.1), 1e-5);
}

TEST(TriangulateTest, LeavesOutUnknownMaskedAndUncertainPixels) {
  DisparityImage image = SeePlane(Eigen::Vector3d::UnitZ(), 2.0);
  image.disparity_px(3, 5) = std::numeric_limits<float>::quiet_NaN();
  image.disparity_px(2, 6) = 0.0f;
  image.sigma_px(3, 7) = 5.0f;
  cv::Mat1b mask(kTinyCamera.height, kTinyCamera.width, static_cast<std::uint8_t>(255));
  mask(2, 8) = 0;
  CloudConfig config = EveryPixel();
  config.max_depth_sigma_m = kTinyCamera.DepthSigma(2.0, 1.0);
  EXPECT_EQ(Triangulate(image, kTinyCamera, config, mask).points.size(), 64u * 48u / 2u - 4u);
}

TEST(TriangulateTest, GivesSomeOfTheUncertainPixelsApart) {
  DisparityImage image = SeePlane(Eigen::Vector3d::UnitZ(), 2.0);
  image.sigma_px.setTo(5.0f);
  CloudConfig config = EveryPixel();
  config.max_depth_sigma_m = kTinyCamera.DepthSigma(2.0, 1.0);
  const Cloud cloud = Triangulate(image, kTinyCamera, config);
  EXPECT_TRUE(cloud.points.empty());
  ASSERT_EQ(cloud.uncertain.size(), 64u * 48u / 16u);
  EXPECT_NEAR(cloud.uncertain[7].p_left.z(), 2.0, 1e-3);
}

TEST(TriangulateTest, TakesFewerPixelsWhereTheyLieDenserThanTheSpacing) {
  // Pixels are 2 m / 40 = 5 cm apart: the white fields of a chessboard down to
  // 5 cm of spacing, every second row and column from 10 cm on.
  const DisparityImage image = SeePlane(Eigen::Vector3d::UnitZ(), 2.0);
  CloudConfig config = EveryPixel();
  config.min_spacing_m = 0.051;
  EXPECT_EQ(Triangulate(image, kTinyCamera, config).points.size(), 64u * 48u / 2u);
  config.min_spacing_m = 0.101;
  EXPECT_EQ(Triangulate(image, kTinyCamera, config).points.size(), 64u * 48u / 4u);
}

TEST(TriangulateTest, RefusesAnImageOfAnotherSizeThanTheCamera) {
  DisparityImage image;
  image.disparity_px.create(10, 10);
  EXPECT_THROW(Triangulate(image, kTinyCamera, {}), CheckError);
}

}  // namespace
}  // namespace terrace
