// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_filters.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

/// Size of each pixel's piece by flooding from it.
int SlowPieceSize(const cv::Mat1f& disparity, int u, int v, float max_difference) {
  cv::Mat1b seen = cv::Mat1b::zeros(disparity.rows, disparity.cols);
  std::vector<cv::Point> todo = {{u, v}};
  seen(v, u) = 1;
  int size = 0;
  while (!todo.empty()) {
    const cv::Point p = todo.back();
    todo.pop_back();
    ++size;
    for (const cv::Point step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const cv::Point q = p + step;
      if (q.x < 0 || q.y < 0 || q.x >= disparity.cols || q.y >= disparity.rows || seen(q)) continue;
      if (!(std::abs(disparity(q) - disparity(p)) <= max_difference)) continue;
      seen(q) = 1;
      todo.push_back(q);
    }
  }
  return size;
}

TEST(RemoveSpecklesTest, KeepsASteepSurfaceThoughItsRowsDiffer) {
  cv::Mat1f disparity(20, 64);
  for (int v = 0; v < 20; ++v) disparity.row(v).setTo(10.0f + 1.8f * static_cast<float>(v));
  SteepSurfaces steep;
  steep.Measure(disparity);
  cv::Mat1f with = disparity.clone(), without = disparity.clone();
  RemoveSpeckles(100, 1.0f, with, {&steep, 1});
  RemoveSpeckles(100, 1.0f, without);
  for (int v = 0; v < 20; ++v)
    for (int u = 0; u < 64; ++u) {
      EXPECT_FALSE(std::isnan(with(v, u))) << u << ' ' << v;
      EXPECT_TRUE(std::isnan(without(v, u))) << u << ' ' << v;
    }
}

TEST(RemoveSpecklesTest, BelievesRepeatedPatternsOnlyWithMoreOfTheirSurfaceAroundThem) {
  cv::Mat1b stripes(40, 160, std::uint8_t{100});
  for (int v = 0; v < 40; ++v)
    for (int u = 80; u < 160; ++u) stripes(v, u) = u / 4 % 2 == 0 ? 40 : 200;
  RepeatedPatterns patterns;
  patterns.Find(stripes);
  cv::Mat1f of_its_own(40, 160, 10.0f), of_the_wall(40, 160, 10.0f);
  of_its_own(cv::Rect(80, 0, 80, 40)).setTo(6.0f);
  RemoveSpeckles(20, 1.0f, of_its_own, {}, {&patterns, 1});
  RemoveSpeckles(20, 1.0f, of_the_wall, {}, {&patterns, 1});
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 160; ++u) {
      EXPECT_EQ(std::isnan(of_its_own(v, u)), u >= 80) << u << ' ' << v;
      EXPECT_EQ(of_the_wall(v, u), 10.0f) << u << ' ' << v;
    }
}

TEST(RemoveSpecklesTest, RemovesWhatFloodingFindsTooSmall) {
  std::mt19937 random(5);
  cv::Mat1f disparity(24, 31);
  for (auto& d : disparity) d = random() % 5 == 0 ? kUnknownDisparity : static_cast<float>(random() % 4);
  cv::Mat1f filtered = disparity.clone();
  RemoveSpeckles(6, 1.0f, filtered);
  for (int v = 0; v < disparity.rows; ++v)
    for (int u = 0; u < disparity.cols; ++u) {
      if (std::isnan(disparity(v, u)) || SlowPieceSize(disparity, u, v, 1.0f) < 6) {
        EXPECT_TRUE(std::isnan(filtered(v, u))) << u << ' ' << v;
      } else {
        EXPECT_EQ(filtered(v, u), disparity(v, u)) << u << ' ' << v;
      }
    }
}

}  // namespace
}  // namespace terrace
