// SPDX-License-Identifier: BSD-3-Clause
#include "terrain/resting_view.h"

#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

/// A floor as a camera shows it, with noise; a box of 40 x 40 pixels may stand before it.
DisparityImage Floor(std::mt19937* random, bool with_box) {
  std::normal_distribution<float> noise(0.0F, 0.2F);
  DisparityImage image;
  image.disparity_px.create(240, 320);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u)
      image.disparity_px(v, u) = 5.0F + 0.1F * static_cast<float>(v) + noise(*random);
  if (with_box) image.disparity_px(cv::Rect(100, 100, 40, 40)) = 35.0F;
  return image;
}

class RestingViewTest : public ::testing::Test {
 protected:
  /// How many of so many frames show something new.
  int NumNew(int num_frames, double x_m, bool with_box = false) {
    int num_new = 0;
    for (int i = 0; i < num_frames; ++i) {
      Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
      T_world_left.translation().x() = x_m + jitter_m_(random_);
      num_new += !resting_.ShowsNothingNew(Floor(&random_, with_box), T_world_left);
    }
    return num_new;
  }

  std::mt19937 random_{1};
  std::uniform_real_distribution<double> jitter_m_{-0.0005, 0.0005};
  RestingView resting_;
};

TEST_F(RestingViewTest, AfterFortyFramesOfTheSameThereIsNothingNew) {
  EXPECT_EQ(NumNew(40, 0.0), 40);
  EXPECT_EQ(NumNew(100, 0.0), 0);
}

TEST_F(RestingViewTest, AFrameThatIsRepeatedSaysNothingNewAfterNineTimes) {
  const DisparityImage image = Floor(&random_, false);
  int num_new = 0;
  for (int i = 0; i < 100; ++i) num_new += !resting_.ShowsNothingNew(image, Eigen::Isometry3d::Identity());
  EXPECT_LE(num_new, 9);
}

TEST_F(RestingViewTest, ABoxThatIsSetDownIsNewAtOnceAndSoIsItsAbsence) {
  NumNew(50, 0.0);
  EXPECT_EQ(NumNew(1, 0.0, true), 1);
  EXPECT_EQ(NumNew(100, 0.0, true), 39);
  EXPECT_EQ(NumNew(1, 0.0, false), 1);
}

TEST_F(RestingViewTest, AFewTilesThatFlickerAreNotNewButAreWhereTheyStayAsTheyAre) {
  NumNew(50, 0.0);
  DisparityImage image = Floor(&random_, false);
  image.disparity_px(cv::Rect(96, 96, 64, 16)) = 60.0F;  // four tiles
  EXPECT_TRUE(resting_.ShowsNothingNew(image, Eigen::Isometry3d::Identity()));
  EXPECT_EQ(NumNew(1, 0.0), 0);
  for (const bool nothing_new : {true, true, false})
    EXPECT_EQ(resting_.ShowsNothingNew(image, Eigen::Isometry3d::Identity()), nothing_new);
}

TEST_F(RestingViewTest, AStepToTheSideIsNewAndSoIsASlowCreep) {
  NumNew(50, 0.0);
  EXPECT_EQ(NumNew(1, 0.01), 1);
  int num_new = 0;
  for (int i = 0; i < 60; ++i) num_new += NumNew(1, 0.01 + 0.001 * i);
  EXPECT_EQ(num_new, 60);
}

TEST_F(RestingViewTest, WhatIsNoLongerMatchedIsNew) {
  NumNew(50, 0.0);
  DisparityImage image = Floor(&random_, false);
  image.disparity_px(cv::Rect(0, 100, 320, 40)) = kUnknownDisparity;
  EXPECT_FALSE(resting_.ShowsNothingNew(image, Eigen::Isometry3d::Identity()));
}

}  // namespace
}  // namespace terrace
