// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/keyframe_archive.h"

#include <gtest/gtest.h>

#include "odometry/rotation.h"
#include "test/odometry/test_cameras.h"
#include "textured_image.h"

namespace terrace {
namespace {

ImagePyramid TexturedPyramid(double du, double dv) {
  cv::Mat1b image(kHalfVgaCamera.height, kHalfVgaCamera.width);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image(v, u) = cv::saturate_cast<std::uint8_t>(Texture(u + du, v + dv));
  return BuildPyramid(image);
}

/// Features on a grid of a wall 2.4 m away; shifted against the grid of TexturedPyramid(0, 0).
std::vector<Landmark> GridOfLandmarks(double du, double dv) {
  std::vector<Landmark> landmarks;
  for (int v = 40; v < 200; v += 16) {
    for (int u = 60; u < 260; u += 16) {
      Landmark landmark;
      landmark.pixel_host << u - du, v - dv;
      landmark.ray_host << (landmark.pixel_host.x() - kHalfVgaCamera.cx) / kHalfVgaCamera.fx,
          (landmark.pixel_host.y() - kHalfVgaCamera.cy) / kHalfVgaCamera.fy, 1.0;
      landmark.disparity_host_px = 10.0;
      landmark.num_tracked = 10;
      landmark.inverse_depth = 10.0 / (kHalfVgaCamera.fx * kHalfVgaCamera.baseline_m);
      landmarks.push_back(landmark);
    }
  }
  return landmarks;
}

TEST(KeyframeArchiveTest, RecognisesAPlaceFromAsideOfIt) {
  KeyframeArchive archive(kHalfVgaCamera, 10);
  Keyframe keyframe;
  keyframe.T_world_left.translation() << 5.0, 1.0, 0.0;
  keyframe.left = TexturedPyramid(0, 0);
  archive.Add(keyframe, GridOfLandmarks(0, 0), Matrix6d::Identity() * 1e-4);

  // 20 px to the right at 2.4 m is a step of 0.24 m.
  const auto found =
      archive.Recognize(TexturedPyramid(20, 0), GridOfLandmarks(20, 0), Eigen::Isometry3d::Identity(), 0, 1);
  ASSERT_TRUE(found);
  EXPECT_LT((found->T_world_left.translation() - Eigen::Vector3d(5.24, 1.0, 0.0)).norm(), 0.02);
  EXPECT_LT(LogRotation(found->T_world_left.linear()).norm(), 0.01);
  EXPECT_GT(found->covariance(5, 5), 1e-4);
}

TEST(KeyframeArchiveTest, DoesNotKeepWhatHasNotProvedToStandStill) {
  KeyframeArchive archive(kHalfVgaCamera, 10);
  Keyframe keyframe;
  keyframe.left = TexturedPyramid(0, 0);
  std::vector<Landmark> landmarks = GridOfLandmarks(0, 0);
  for (Landmark& landmark : landmarks) landmark.num_tracked = 0;
  archive.Add(keyframe, landmarks, Matrix6d::Zero());
  ASSERT_EQ(archive.keyframes().size(), 1u);
  EXPECT_TRUE(archive.keyframes()[0].points.empty());
  archive.Add(keyframe, GridOfLandmarks(0, 0), Matrix6d::Zero());
  ASSERT_EQ(archive.keyframes().size(), 1u);
  EXPECT_FALSE(archive.keyframes()[0].points.empty());
}

TEST(KeyframeArchiveTest, DoesNotRecogniseAnotherPlace) {
  KeyframeArchive archive(kHalfVgaCamera, 10);
  Keyframe keyframe;
  keyframe.left = TexturedPyramid(0, 0);
  archive.Add(keyframe, GridOfLandmarks(0, 0), Matrix6d::Zero());
  EXPECT_FALSE(archive.Recognize(TexturedPyramid(5000, 3000), GridOfLandmarks(0, 0),
                                 Eigen::Isometry3d::Identity(), 0, 1));
}

TEST(KeyframeArchiveTest, StaysBoundedAndKeepsTheFirstAndTheNewest) {
  KeyframeArchive archive(kHalfVgaCamera, 20);
  Keyframe keyframe;
  keyframe.left = TexturedPyramid(0, 0);
  for (int i = 0; i < 200; ++i) {
    keyframe.id = i;
    archive.Add(keyframe, {}, Matrix6d::Zero());
    ASSERT_LE(archive.keyframes().size(), 20u);
  }
  EXPECT_EQ(archive.keyframes().front().id, 0);
  EXPECT_EQ(archive.keyframes().back().id, 199);
}

}  // namespace
}  // namespace terrace
