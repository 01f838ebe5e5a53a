// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/patch_search.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include <gtest/gtest.h>

#include "test/every_target.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

/// The right image, so many rows further down.
cv::Mat1b Lowered(const cv::Mat1b& image, int rows) {
  cv::Mat1b lowered(image.size());
  for (int v = 0; v < image.rows; ++v)
    image.row(std::clamp(v - rows, 0, image.rows - 1)).copyTo(lowered.row(v));
  return lowered;
}

int SumOfDifferences(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, const PatchMatch& match) {
  int sum = 0;
  for (int b = v - kPatchHeight / 2; b < v + kPatchHeight / 2; ++b)
    for (int a = u - kPatchWidth / 2; a < u + kPatchWidth / 2; ++a)
      sum += std::abs(left(b, a) - right(b + match.rows, a - match.disparity));
  return sum;
}

TEST(PatchSearchTest, FindsWhatTheSlowSearchFindsOnEveryTarget) {
  const StereoFrame frame = RenderPlane(200, 80, {21.0, 0.0, 0.0});
  const cv::Mat1b right = Lowered(frame.right, 2);
  const PatchRange range{48, -3, 3};
  int num_found = 0;
  for (int u = 70; u < 190; u += 7) {
    PatchMatch best;
    int least = 1 << 30;
    for (int rows = -3; rows <= 3; ++rows)
      for (int disparity = 0; disparity < 48; ++disparity) {
        const int sum = SumOfDifferences(frame.left, right, u, 40, {disparity, rows});
        if (sum < least) least = sum, best = {disparity, rows};
      }
    OnEveryTarget([&] {
      const std::optional<PatchMatch> found = FindPatch(frame.left, right, u, 40, range);
      if (!found) return;
      ++num_found;
      EXPECT_EQ(found->disparity, best.disparity);
      EXPECT_EQ(found->rows, best.rows);
      EXPECT_EQ(found->disparity, 21);
      EXPECT_EQ(found->rows, 2);
    });
  }
  EXPECT_GT(num_found, 10);
}

TEST(PatchSearchTest, FindsNothingThatCouldBeElsewhereOrHasNoTexture) {
  const StereoFrame one = RenderPlane(200, 80, {21.0, 0.0, 0.0}),
                    other = RenderPlane(200, 80, {21.0, 0.0, 0.0}, {}, 5);
  const cv::Mat1b flat(80, 200, static_cast<std::uint8_t>(90));
  cv::Mat1b tiles(80, 200);
  for (int v = 0; v < 80; ++v)
    for (int u = 0; u < 200; ++u) tiles(v, u) = (u / 4 + v / 4) % 2 == 0 ? 60 : 180;
  for (int u = 70; u < 190; u += 7) {
    EXPECT_FALSE(FindPatch(flat, flat, u, 40, {48, -3, 3}));
    EXPECT_FALSE(FindPatch(one.left, flat, u, 40, {48, -3, 3}));
    EXPECT_FALSE(FindPatch(one.left, other.right, u, 40, {48, -3, 3}));
    EXPECT_FALSE(FindPatch(tiles, tiles, u, 40, {48, -3, 3}));
  }
}

TEST(PatchSearchTest, FindsNothingAtTheBorders) {
  const StereoFrame frame = RenderPlane(60, 30, {5.0, 0.0, 0.0});
  for (int u = -3; u < 63; ++u)
    for (const int v : {-1, 0, 3, 27, 30})
      EXPECT_FALSE(FindPatch(frame.left, frame.right, u, v, {16, -3, 3}));
}

}  // namespace
}  // namespace terrace
