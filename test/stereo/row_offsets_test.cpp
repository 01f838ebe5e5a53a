// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/row_offsets.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

/// A plane seen by a pair whose right image shows everything `offsets` further down.
StereoFrame RenderMisaligned(int width, int height, const RowOffsets& offsets, const Photometry& light = {}) {
  const WaveTexture texture(1);
  const SlantedPlane plane{14.0, 0.01, 0.02};
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, light.noise);
  StereoFrame frame;
  frame.left.create(height, width);
  frame.right.create(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const double v_left = v - offsets.At(static_cast<float>(u) - 0.5f * static_cast<float>(width),
                                           static_cast<float>(v) - 0.5f * static_cast<float>(height));
      const double u_left = (u + plane.d0 + plane.dv * v_left) / (1.0 - plane.du);
      frame.left(v, u) =
          cv::saturate_cast<std::uint8_t>(light.mean + light.contrast * texture(u, v) + noise(random));
      frame.right(v, u) = cv::saturate_cast<std::uint8_t>(
          (light.mean + light.contrast * texture(u_left, v_left)) * light.gain_right + light.offset_right +
          noise(random));
    }
  return frame;
}

TEST(RowOffsetsTest, MeasuresShiftRollAndStretch) {
  for (const RowOffsets& true_offsets :
       {RowOffsets{}, RowOffsets{.centre_px = 0.3f}, RowOffsets{.centre_px = -2.6f},
        RowOffsets{.centre_px = 0.5f, .per_column = 0.006f},
        RowOffsets{.centre_px = -0.2f, .per_column = -0.002f, .per_row = 0.004f}}) {
    const StereoFrame frame = RenderMisaligned(320, 240, true_offsets);
    const RowOffsets found = MeasureRowOffsets(frame.left, frame.right, 32);
    ASSERT_GT(found.num_places, 50);
    for (const float x : {-140.0f, 0.0f, 140.0f})
      for (const float y : {-100.0f, 0.0f, 100.0f})
        EXPECT_NEAR(found.At(x, y), true_offsets.At(x, y), 0.06)
            << x << " " << y;  // smooth texture, no edges
    EXPECT_LT(found.spread_px, 0.1);
  }
}

TEST(RowOffsetsTest, FindsWhatIsFartherOffThanACalibrationMay) {
  for (const RowOffsets& true_offsets :
       {RowOffsets{.centre_px = 9.0f}, RowOffsets{.centre_px = -6.0f, .per_column = 0.01f},
        RowOffsets{.per_column = 0.026f}}) {
    const StereoFrame frame = RenderMisaligned(320, 240, true_offsets);
    const RowOffsets found = MeasureRowOffsets(frame.left, frame.right, 32);
    EXPECT_GT(found.num_places, 50) << true_offsets.centre_px;
    constexpr double kClose_px = 0.12;
    for (const float x : {-140.0f, 0.0f, 140.0f})
      EXPECT_NEAR(found.At(x, 0), true_offsets.At(x, 0), kClose_px) << x;
  }
}

TEST(RowOffsetsTest, MeasuresThemWhenTheRightImageIsHalfAsBright) {
  const StereoFrame frame =
      RenderMisaligned(320, 240, {.centre_px = 0.4f}, {.gain_right = 0.5, .offset_right = 5});
  const RowOffsets found = MeasureRowOffsets(frame.left, frame.right, 32);
  ASSERT_GT(found.num_places, 50);
  EXPECT_NEAR(found.centre_px, 0.4, 0.04);
}

TEST(RowOffsetsTest, KnowsNothingOfBlankImagesOrOfTwoDifferentThings) {
  const StereoFrame one = RenderPlane(320, 240, {10.0}, {}, 1), other = RenderPlane(320, 240, {10.0}, {}, 2);
  const cv::Mat1b blank(240, 320, static_cast<std::uint8_t>(255));
  EXPECT_EQ(MeasureRowOffsets(one.left, blank, 32).num_places, 0);
  EXPECT_EQ(MeasureRowOffsets(blank, one.right, 32).num_places, 0);
  EXPECT_EQ(MeasureRowOffsets(one.left, other.right, 32).num_places, 0);
  EXPECT_EQ(
      MeasureRowOffsets(one.left(cv::Rect(0, 0, 12, 5)), one.right(cv::Rect(0, 0, 12, 5)), 32).num_places, 0);
}

TEST(RowOffsetsTest, StraightenedRowsAreThoseOfAnAlignedPair) {
  const RowOffsets offsets{.centre_px = 0.7f, .per_column = 0.004f, .per_row = -0.003f};
  const StereoFrame aligned = RenderMisaligned(320, 240, {}, {.noise = 0.0}),
                    misaligned = RenderMisaligned(320, 240, offsets, {.noise = 0.0});
  cv::Mat1b straight;
  StraightenRows(misaligned.right, offsets, straight);
  double squares = 0.0, squares_before = 0.0;
  for (int v = 5; v < 235; ++v)
    for (int u = 0; u < 320; ++u) {
      squares += std::pow(straight(v, u) - aligned.right(v, u), 2);
      squares_before += std::pow(misaligned.right(v, u) - aligned.right(v, u), 2);
    }
  EXPECT_LT(std::sqrt(squares / (230 * 320)), 1.5);  // grey levels, of a texture whose spread is 35
  EXPECT_GT(std::sqrt(squares_before / (230 * 320)), 10.0);
}

}  // namespace
}  // namespace terrace
