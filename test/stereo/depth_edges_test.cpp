// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/depth_edges.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "test/every_target.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

constexpr int kWidth = 120, kHeight = 30, kEdge = 60;
constexpr float kFar = 5.0f, kNear = 12.0f;
constexpr int kHidden = 7;  // columns left of the edge that the right camera does not see

/// A near surface from column kEdge on, before a far one.
StereoFrame TwoSurfaces() {
  StereoFrame frame = RenderPlane(kWidth, kHeight, {kFar, 0, 0}, {}, 1);
  const StereoFrame near_frame = RenderPlane(kWidth, kHeight, {kNear, 0, 0}, {}, 2);
  for (int v = 0; v < kHeight; ++v)
    for (int u = kEdge; u < kWidth; ++u) {
      frame.left(v, u) = near_frame.left(v, u);
      frame.right(v, u - 12) = near_frame.right(v, u - 12);
    }
  return frame;
}

void Sharpen(const StereoFrame& frame, cv::Mat1f& disparity) {
  UnitImage units;
  units.Set(disparity);
  DepthEdgeSharpener({}).Sharpen(frame.left, frame.right, units);
  for (int v = 0; v < disparity.rows; ++v)
    for (int u = 0; u < disparity.cols; ++u) disparity(v, u) = units.Px(v, u);
}

TEST(DepthEdgesTest, MovesAnEdgeThatIsThreePixelsOffToItsPlace) {
  const StereoFrame frame = TwoSurfaces();
  cv::Mat1f disparity(kHeight, kWidth);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) disparity(v, u) = u >= kEdge + 3 ? kNear : kFar;
  Sharpen(frame, disparity);
  int right_near = 0, invented = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = kEdge; u < kEdge + 3; ++u) right_near += disparity(v, u) == kNear;
    for (int u = kEdge - kHidden; u < kEdge; ++u) invented += !std::isnan(disparity(v, u));
  }
  EXPECT_GT(right_near, 0.9 * 3 * kHeight);
  EXPECT_LT(invented, 0.2 * kHidden * kHeight);
}

TEST(DepthEdgesTest, TakesASteepSurfaceForNoEdge) {
  const SlantedPlane plane{10.0, 0.0, 0.9};
  // So little texture that noise says which disparity agrees best.
  const StereoFrame frame = RenderPlane(kWidth, kHeight, plane, {.contrast = 2});
  cv::Mat1f disparity(kHeight, kWidth);
  for (int v = 0; v < kHeight; ++v) disparity.row(v).setTo(static_cast<float>(plane.At(0, v)) + 0.4f);
  const cv::Mat1f given = disparity.clone();
  SteepSurfaces steep;
  steep.Measure(given);
  UnitImage units;
  units.Set(disparity);
  DepthEdgeSharpener({}).Sharpen(frame.left, frame.right, units, {&steep, 1});
  int moved = 0;
  for (int v = 3; v < kHeight - 3; ++v)
    for (int u = 50; u < kWidth; ++u) moved += std::abs(units.Px(v, u) - given(v, u)) > 0.1f;
  EXPECT_EQ(moved, 0);
}

TEST(DepthEdgesTest, GivesAnUnknownPixelItsNeighboursDisparityOnlyWhereTheImagesAgree) {
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  StereoFrame frame = RenderPlane(kWidth, kHeight, {kFar, 0, 0});
  for (int v = 10; v < 20; ++v)
    for (int u = 70; u < 80; ++u) frame.right(v, u - 5) = 255 - frame.right(v, u - 5);  // a reflection
  cv::Mat1f disparity(kHeight, kWidth, kFar);
  disparity(5, 50) = unknown, disparity(15, 75) = unknown;
  Sharpen(frame, disparity);
  EXPECT_EQ(disparity(5, 50), kFar);
  EXPECT_TRUE(std::isnan(disparity(15, 75)));
}

TEST(DepthEdgesTest, LeavesASlantedSurfaceAlone) {
  const SlantedPlane plane{8.0, 0.02, 0.3};
  const StereoFrame frame = RenderPlane(kWidth, kHeight, plane);
  cv::Mat1f disparity(kHeight, kWidth), expected;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      disparity(v, u) = std::round(static_cast<float>(plane.At(u, v)) * 128.0f) / 128.0f;
  expected = disparity.clone();
  Sharpen(frame, disparity);
  EXPECT_TRUE(std::equal(disparity.begin(), disparity.end(), expected.begin()));
}

TEST(DepthEdgesTest, GivesTheSameBitsOnEveryTarget) {
  const StereoFrame frame = TwoSurfaces();
  // Two surfaces with holes and wrong values everywhere.
  std::mt19937 random(1);
  cv::Mat1f disparity(kHeight, kWidth);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const float sound = u >= kEdge - 2 ? kNear : kFar;
      const unsigned die = random() % 8;
      disparity(v, u) = die == 0   ? std::numeric_limits<float>::quiet_NaN()
                        : die == 1 ? static_cast<float>(random() % 160) / 10.0f
                                   : sound;
    }
  std::vector<cv::Mat1f> results;
  OnEveryTarget([&] {
    results.push_back(disparity.clone());
    Sharpen(frame, results.back());
  });
  for (const cv::Mat1f& result : results) {
    int different = 0;
    for (int i = 0; i < static_cast<int>(result.total()); ++i)
      different += std::isnan(result(i)) ? !std::isnan(results[0](i)) : result(i) != results[0](i);
    EXPECT_EQ(different, 0);
  }
}

}  // namespace
}  // namespace terrace
