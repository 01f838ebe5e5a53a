// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "core/check.h"
#include "test/stereo/every_target.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(DisparityConfigTest, ListsEveryProblemAtOnce) {
  EXPECT_THAT(DisparityConfig{}.Problems(), IsEmpty());
  DisparityConfig config;
  config.max_disparity_px = 100;
  config.tier = "best";
  config.large_step_penalty = 51;
  EXPECT_THAT(config.Problems(),
              ElementsAre(HasSubstr("max_disparity_px is 100"), HasSubstr("tier is \"best\""),
                          HasSubstr("large_step_penalty <= 50")));
  EXPECT_THROW(DisparityMatcher{config}, std::invalid_argument);
}

DisparityConfig Tier(const std::string& tier, int max_disparity_px) {
  DisparityConfig config;
  config.tier = tier;
  config.max_disparity_px = max_disparity_px;
  return config;
}

class DisparityMatcherTest : public testing::TestWithParam<std::string> {};

TEST_P(DisparityMatcherTest, FindsASlantedPlaneWhereverBothCamerasSeeIt) {
  DisparityMatcher matcher(Tier(GetParam(), 32));
  const SlantedPlane plane{8.3, 0.01, 0.05};
  StereoFrame frame = RenderPlane(160, 120, plane);
  frame.frame_id = 7;
  const DisparityImage result = matcher.Match(frame);
  EXPECT_EQ(result.frame_id, 7);
  std::vector<double> errors;
  int visible = 0, invented = 0;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      const bool known = !std::isnan(result.disparity_px(v, u));
      EXPECT_EQ(known, !std::isnan(result.sigma_px(v, u)));
      if (u - plane.At(u, v) < 0) {
        invented += known;
        continue;
      }
      ++visible;
      if (known) errors.push_back(std::abs(result.disparity_px(v, u) - plane.At(u, v)));
    }
  EXPECT_GT(static_cast<double>(errors.size()), 0.97 * visible);
  EXPECT_LT(invented, 120);  // about one pixel a row
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.03);
}

TEST_P(DisparityMatcherTest, GivesTheSameBitsForAnyNumberOfThreadsAndOnEveryTarget) {
  const StereoFrame frame = RenderPlane(97, 75, {8.3, 0.01, 0.05});
  std::vector<DisparityImage> results;
  for (const int num_threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, num_threads);
    results.push_back(DisparityMatcher(Tier(GetParam(), 32)).Match(frame));
  }
  OnEveryTarget([&] { results.push_back(DisparityMatcher(Tier(GetParam(), 32)).Match(frame)); });
  const std::size_t bytes = results[0].disparity_px.total() * sizeof(float);
  for (const DisparityImage& result : results) {
    EXPECT_EQ(std::memcmp(result.disparity_px.data, results[0].disparity_px.data, bytes), 0);
    EXPECT_EQ(std::memcmp(result.sigma_px.data, results[0].sigma_px.data, bytes), 0);
  }
}

TEST_P(DisparityMatcherTest, TakesAnyImageFromSixteenPixelsOnAndAnyRange) {
  for (const cv::Size size : {cv::Size(16, 16), cv::Size(17, 31), cv::Size(300, 16)})
    for (const int range : {16, 48, 256}) {
      const StereoFrame frame = RenderPlane(size.width, size.height, {3.0, 0, 0});
      EXPECT_EQ(DisparityMatcher(Tier(GetParam(), range)).Match(frame).disparity_px.size(), size);
    }
}

TEST_P(DisparityMatcherTest, KnowsNothingWhereThereIsNothingToSee) {
  StereoFrame frame;
  frame.left = cv::Mat1b(60, 80, static_cast<std::uint8_t>(0));
  frame.right = frame.left.clone();
  const DisparityImage result = DisparityMatcher(Tier(GetParam(), 32)).Match(frame);
  for (const float d : result.disparity_px) EXPECT_TRUE(std::isnan(d));
}

TEST_P(DisparityMatcherTest, RefusesImagesOfUnequalSize) {
  DisparityMatcher matcher(Tier(GetParam(), 32));
  StereoFrame frame;
  frame.left.create(20, 20);
  frame.right.create(20, 21);
  EXPECT_THROW(matcher.Match(frame), CheckError);
}

INSTANTIATE_TEST_SUITE_P(Tiers, DisparityMatcherTest, testing::Values("fast", "quality"),
                         [](const auto& tier) { return tier.param; });

}  // namespace
}  // namespace terrace
