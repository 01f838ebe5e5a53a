// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/pair_monitor.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stereo/disparity_matcher.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

using testing::HasSubstr;

constexpr int kPairWidth = 480, kPairHeight = 360;
const SlantedPlane kFloor{10.0, 0.005, 0.05};

StereoFrame Healthy(unsigned seed = 1) {
  return RenderPlane(kPairWidth, kPairHeight, kFloor, {.noise = 1.5}, seed);
}

PairHealth CheckOnce(const StereoFrame& frame) {
  DisparityConfig config;
  config.max_disparity_px = 64;
  return PairMonitor().Check(frame, DisparityMatcher(config).Match(frame));
}

/// An image of one brightness, with a little noise.
cv::Mat1b Covered(double brightness, double sigma = 0.4) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, sigma);
  cv::Mat1b image(kPairHeight, kPairWidth);
  for (std::uint8_t& pixel : image) pixel = cv::saturate_cast<std::uint8_t>(brightness + noise(random));
  return image;
}

TEST(PairMonitorTest, FindsNothingWrongWithAHealthyPair) {
  const PairHealth health = CheckOnce(Healthy());
  EXPECT_FALSE(health.stops_mapping());
  EXPECT_EQ(health.Reason(), "");
  EXPECT_NEAR(health.brightness_ratio, 1.0, 0.05);
  EXPECT_GT(health.known_share, 0.8);
  EXPECT_LT(health.limit_share, 0.01);
}

TEST(PairMonitorTest, TellsWhichOfTheCamerasIsFrozen) {
  DisparityConfig config;
  config.max_disparity_px = 64;
  DisparityMatcher matcher(config);
  const StereoFrame frozen = Healthy(1);
  for (const bool left : {true, false}) {
    PairMonitor monitor;
    PairHealth health;
    for (unsigned i = 2; i < 6; ++i) {
      StereoFrame frame = Healthy(i);
      (left ? frame.left : frame.right) = (left ? frozen.left : frozen.right).clone();
      health = monitor.Check(frame, matcher.Match(frame));
    }
    EXPECT_TRUE(health.stops_mapping());
    EXPECT_THAT(health.Reason(),
                HasSubstr(left ? "left camera gives the same" : "right camera gives the same"));
  }
  PairMonitor monitor;
  PairHealth health;
  for (int i = 0; i < 12; ++i) health = monitor.Check(frozen, matcher.Match(frozen));
  EXPECT_FALSE(health.stops_mapping()) << "a recording of one pair";
  EXPECT_THAT(health.Reason(), HasSubstr("both cameras give the same"));
}

TEST(PairMonitorTest, TellsABlankImageWhetherBlackWhiteOrCovered) {
  for (const double brightness : {0.0, 2.0, 255.0}) {
    StereoFrame frame = Healthy();
    frame.right = Covered(brightness);
    const PairHealth right = CheckOnce(frame);
    EXPECT_TRUE(right.right_blank && !right.left_blank && right.stops_mapping()) << brightness;
    EXPECT_THAT(right.Reason(), HasSubstr("right image is blank"));
    EXPECT_LT(right.known_share, 0.05) << brightness;  // what the matcher makes of it
    std::swap(frame.left, frame.right);
    EXPECT_THAT(CheckOnce(frame).Reason(), HasSubstr("left image is blank")) << brightness;
    frame.right = frame.left.clone();
    EXPECT_THAT(CheckOnce(frame).Reason(), HasSubstr("both images are blank")) << brightness;
  }
}

TEST(PairMonitorTest, TellsACoveredLensByItsNoise) {
  StereoFrame frame = Healthy();
  frame.right = Covered(4.0, 1.0);
  EXPECT_TRUE(CheckOnce(frame).right_blank);
  frame.right = Healthy().right * 0.15;
  EXPECT_FALSE(CheckOnce(frame).right_blank) << "dim is not dark";
}

TEST(PairMonitorTest, NamesTheBrightnessOfWhatDoesNotMatch) {
  StereoFrame frame = Healthy();
  frame.right = Healthy(2).right * 2;
  EXPECT_THAT(CheckOnce(frame).Reason(), HasSubstr("times as bright"));
}

TEST(PairMonitorTest, TellsAHalfBlankImage) {
  StereoFrame frame = Healthy();
  frame.right(cv::Rect(0, 0, kPairWidth / 2, kPairHeight)).setTo(255);
  const PairHealth health = CheckOnce(frame);
  EXPECT_TRUE(health.half_blank && health.stops_mapping());
  EXPECT_THAT(health.Reason(), HasSubstr("of the right image"));
  EXPECT_NEAR(health.right_blank_share, 0.5, 0.05);
}

TEST(PairMonitorTest, TellsTwoImagesOfDifferentThings) {
  StereoFrame frame = Healthy();
  frame.right = Healthy(2).right;
  const PairHealth health = CheckOnce(frame);
  EXPECT_TRUE(health.different && health.stops_mapping());
  EXPECT_THAT(health.Reason(), HasSubstr("do not show the same"));
  EXPECT_LT(health.known_share, 0.1);
}

TEST(PairMonitorTest, APlatformUnderAWideSkyIsNoPairOfDifferentThings) {
  // Above ground of little contrast nothing but noise, another one in each image.
  StereoFrame frame = RenderPlane(kPairWidth, kPairHeight, kFloor, {.contrast = 10.0});
  std::mt19937 random(5);
  std::normal_distribution<double> noise(140.0, 1.5);
  for (cv::Mat1b* image : {&frame.left, &frame.right})
    for (int v = 0; v < kPairHeight * 2 / 3; ++v)
      for (int u = 0; u < kPairWidth; ++u) (*image)(v, u) = cv::saturate_cast<std::uint8_t>(noise(random));
  const PairHealth health = CheckOnce(frame);
  EXPECT_FALSE(health.different);
  EXPECT_GT(health.known_share, 0.8);
}

/// Straightening what is straight moves it by as much the other way.
StereoFrame Misaligned(const RowOffsets& offsets, unsigned seed = 1) {
  StereoFrame frame = Healthy(seed);
  StraightenRows(Healthy(seed).right, {-offsets.centre_px, -offsets.per_column, -offsets.per_row},
                 frame.right);
  return frame;
}

TEST(PairMonitorTest, MeasuresRowsThatAreOff) {
  const PairHealth health = CheckOnce(Misaligned({.centre_px = 3.2f}));
  EXPECT_NEAR(health.row_offsets.centre_px, 3.2, 0.15);
  EXPECT_TRUE(health.rows_off);
  EXPECT_FALSE(health.stops_mapping());  // the matcher takes it out
  EXPECT_THAT(health.Reason(), HasSubstr("off by 3."));
}

TEST(PairMonitorTest, StopsMappingWhereARollOrAnotherSizeMakesDisparitiesWrong) {
  for (const RowOffsets& offsets :
       {RowOffsets{.per_column = 0.007f}, RowOffsets{.per_column = 0.026f}, RowOffsets{.per_row = 0.01f}}) {
    const PairHealth health = CheckOnce(Misaligned(offsets));
    EXPECT_TRUE(health.warped && health.stops_mapping() && health.misplaces())
        << offsets.per_column << " " << offsets.per_row;
    EXPECT_THAT(health.Reason(), HasSubstr("rolled or of another size"));
    const float expected =
        std::hypot(offsets.per_column * kPairHeight, offsets.per_row * kPairWidth) / std::sqrt(12.0f);
    EXPECT_NEAR(health.disparity_error_px, expected, 0.2 * expected);
  }
}

TEST(PairMonitorTest, TellsThatRowsComeAndGoWhenOneCameraIsLate) {
  DisparityConfig config;
  config.max_disparity_px = 64;
  DisparityMatcher matcher(config);
  PairMonitor monitor;
  const auto check = [&](float rows_px, unsigned seed) {
    const StereoFrame frame = Misaligned({.centre_px = rows_px}, seed);
    return monitor.Check(frame, matcher.Match(frame));
  };
  EXPECT_FALSE(check(0.0f, 1).not_at_once);
  EXPECT_TRUE(check(2.0f, 2).not_at_once);
  EXPECT_TRUE(check(-1.5f, 3).not_at_once);
  const PairHealth calm = check(-1.5f, 4);
  EXPECT_TRUE(calm.not_at_once) << "twice was no chance";
  EXPECT_THAT(calm.Reason(), HasSubstr("not of one moment"));
}

TEST(LastingFindingTest, LastsOnceItWasMadeTwiceAndEndsWhenItIsNotMadeForLong) {
  LastingFinding once;
  EXPECT_TRUE(once.Update(true));
  EXPECT_FALSE(once.Update(false));
  EXPECT_FALSE(once.Update(std::nullopt));
  LastingFinding twice;
  twice.Update(true), twice.Update(true);
  for (int i = 0; i < 14; ++i) EXPECT_TRUE(twice.Update(false)) << i;
  EXPECT_TRUE(twice.Update(std::nullopt)) << "a frame that does not say changes nothing";
  EXPECT_FALSE(twice.Update(false));
}

TEST(PairMonitorTest, MeasuresBrightness) {
  StereoFrame frame = Healthy();
  frame.right.convertTo(frame.right, CV_8U, 0.5);
  const PairHealth health = CheckOnce(frame);
  EXPECT_NEAR(health.brightness_ratio, 0.5, 0.03);
  EXPECT_FALSE(health.stops_mapping());
}

TEST(PairMonitorTest, CountsFramesThatShowTheSameBits) {
  DisparityMatcher matcher({.max_disparity_px = 64});
  PairMonitor monitor;
  const StereoFrame first = Healthy(1), second = Healthy(2);
  EXPECT_EQ(monitor.Check(first, matcher.Match(first)).num_same_left, 0);
  EXPECT_EQ(monitor.Check(first, matcher.Match(first)).num_same_left, 1);
  StereoFrame frozen_right = second;
  frozen_right.right = first.right;
  const PairHealth health = monitor.Check(frozen_right, matcher.Match(frozen_right));
  EXPECT_EQ(health.num_same_left, 0);
  EXPECT_EQ(health.num_same_right, 2);
  EXPECT_EQ(monitor.Check(second, matcher.Match(second)).num_same_right, 0);
}

TEST(PairMonitorTest, TellsWhatIsNearerThanTheSearchGoes) {
  const StereoFrame frame = RenderPlane(kPairWidth, kPairHeight, {90.0});
  const PairHealth health = CheckOnce(frame);
  EXPECT_LT(health.known_share, 0.1);
  EXPECT_GT(health.no_match_share + health.limit_share, 0.1);
}

}  // namespace
}  // namespace terrace
