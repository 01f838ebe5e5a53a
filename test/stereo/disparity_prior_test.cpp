// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_prior.h"


#include <gtest/gtest.h>

#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

const StereoCamera kCamera{160, 96, 100.0, 100.0, 79.5, 47.5, 0.12};

/// A wall across the view.
DisparityImage Wall(double depth_m) {
  DisparityImage image;
  image.disparity_px = cv::Mat1f(96, 160, static_cast<float>(kCamera.Disparity(depth_m)));
  return image;
}

TEST(DisparityPriorTest, ExpectsAWallNearerAfterAStepTowardsIt) {
  Eigen::Isometry3d T_now_earlier = Eigen::Isometry3d::Identity();
  T_now_earlier.translation().z() = -0.5;
  const DisparityPrior prior = PredictDisparities(Wall(1.0), kCamera, T_now_earlier);
  ASSERT_EQ(prior.rows, 3);
  ASSERT_EQ(prior.columns, 5);
  // Seen twice as large: a quarter of the samples is left for each tile.
  EXPECT_FALSE(prior.At(1, 2).known());
  T_now_earlier.translation().z() = -0.1;
  const DisparityPrior::Range range = PredictDisparities(Wall(1.0), kCamera, T_now_earlier).At(1, 2);
  ASSERT_TRUE(range.known());
  const double d = kCamera.Disparity(0.9);
  EXPECT_LE(range.low_px, d);
  EXPECT_GE(range.high_px, d);
  EXPECT_LE(range.high_px - range.low_px, 8.0f);
}

TEST(DisparityPriorTest, LeavesOpenWhatComesIntoView) {
  Eigen::Isometry3d T_now_earlier = Eigen::Isometry3d::Identity();
  T_now_earlier.translation().x() = -0.5;  // the camera goes to the right: 50 px of the wall are new there
  const DisparityPrior prior = PredictDisparities(Wall(1.0), kCamera, T_now_earlier);
  EXPECT_TRUE(prior.At(1, 1).known());
  EXPECT_FALSE(prior.At(1, 3).known());
  EXPECT_FALSE(prior.At(1, 4).known());
}

TEST(DisparityPriorTest, LeavesOpenWhatWasUnknownAndDoesNotBelieveASinglePixel) {
  DisparityImage earlier = Wall(1.0);
  earlier.disparity_px(cv::Rect(32, 32, 32, 32)) = kUnknownDisparity;
  earlier.disparity_px(12, 12) = 60.0f;
  const DisparityPrior prior = PredictDisparities(earlier, kCamera, Eigen::Isometry3d::Identity());
  EXPECT_FALSE(prior.At(1, 1).known());
  ASSERT_TRUE(prior.At(0, 0).known());
  EXPECT_LT(prior.At(0, 0).high_px, 20.0f);
}

}  // namespace
}  // namespace terrace
