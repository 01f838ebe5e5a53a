// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/consistency.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace terrace {
namespace {

const StereoCamera kCamera{80, 60, 100.0, 100.0, 39.5, 29.5, 0.1};

FloatImage Flat(double disparity_px) {
  FloatImage image(kCamera.width, kCamera.height);
  std::fill(image.data.begin(), image.data.end(), static_cast<float>(disparity_px));
  return image;
}

/// A left image of waves, and the right one as a plane at the given disparity makes it, brighter by `gain`.
StereoPair Waves(double disparity_px, double gain) {
  StereoPair pair;
  for (GrayImage* image : {&pair.left, &pair.right}) {
    *image = {kCamera.width, kCamera.height, {}};
    const double shift = image == &pair.right ? disparity_px : 0.0;
    for (int v = 0; v < image->height; ++v) {
      for (int u = 0; u < image->width; ++u) {
        const double grey = 100.0 + 50.0 * std::sin(0.4 * (u + shift));
        image->data.push_back(static_cast<std::uint8_t>(std::lround(grey * (shift > 0.0 ? gain : 1.0))));
      }
    }
  }
  return pair;
}

TEST(ConsistencyTest, FindsThatARightDisparityWarpsOneImageOntoTheOther) {
  const StereoPair pair = Waves(8.0, 1.2);
  ConsistencyMeter right(kCamera), wrong(kCamera);
  right.Add(Flat(8.0), &pair, std::nullopt);
  wrong.Add(Flat(12.0), &pair, std::nullopt);
  EXPECT_LT(right.Result().photometric_p90, 2.0);
  EXPECT_GT(wrong.Result().photometric_median, 20.0);
  EXPECT_EQ(right.Result().num_temporal, 0);
}

TEST(ConsistencyTest, ComparesWhatTheMotionPredictsWithWhatTheNextImageSays) {
  // A wall 2 m away (5 px), then 0.4 m nearer (6.25 px).
  Eigen::Isometry3d nearer = Eigen::Isometry3d::Identity();
  nearer.translation().z() = 0.4;
  ConsistencyMeter right(kCamera), wrong(kCamera);
  right.Add(Flat(5.0), nullptr, Eigen::Isometry3d::Identity());
  right.Add(Flat(6.25), nullptr, nearer);
  wrong.Add(Flat(5.0), nullptr, Eigen::Isometry3d::Identity());
  wrong.Add(Flat(5.0), nullptr, nearer);
  EXPECT_NEAR(right.Result().temporal_median_px, 0.0, 1e-5);
  EXPECT_EQ(right.Result().temporal_off_pct, 0.0);
  EXPECT_NEAR(wrong.Result().temporal_median_px, 1.25, 1e-5);
  EXPECT_EQ(wrong.Result().temporal_off_pct, 100.0);
}

TEST(ConsistencyTest, ComparesNothingAcrossAFrameThatWasNotTracked) {
  ConsistencyMeter meter(kCamera);
  meter.Add(Flat(5.0), nullptr, Eigen::Isometry3d::Identity());
  meter.Add(Flat(9.0), nullptr, std::nullopt);
  meter.Add(Flat(5.0), nullptr, Eigen::Isometry3d::Identity());
  EXPECT_EQ(meter.Result().num_temporal, 0);
  EXPECT_EQ(meter.Result().num_images, 3);
}

TEST(ConsistencyTest, CountsPixelsWithAValue) {
  FloatImage half = Flat(5.0);
  for (std::size_t i = 0; i < half.data.size() / 2; ++i)
    half.data[i] = std::numeric_limits<float>::quiet_NaN();
  ConsistencyMeter meter(kCamera);
  meter.Add(half, nullptr, std::nullopt);
  EXPECT_NEAR(meter.Result().density_pct, 50.0, 1e-9);
}

}  // namespace
}  // namespace terrace
