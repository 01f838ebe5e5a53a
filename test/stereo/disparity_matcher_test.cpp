// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_matcher.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/check.h"
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
  config.max_left_right_error_px = -1.0;
  EXPECT_THAT(config.Problems(),
              ElementsAre(HasSubstr("max_disparity_px is 100"), HasSubstr("must not be negative")));
  EXPECT_THROW(DisparityMatcher{config}, std::invalid_argument);
}

TEST(DisparityMatcherTest, FindsASlantedPlaneWhereverBothCamerasSeeIt) {
  DisparityConfig config;
  config.max_disparity_px = 32;
  DisparityMatcher matcher(config);
  const SlantedPlane plane{8.3, 0.01, 0.05};
  StereoFrame frame = RenderPlane(160, 120, plane);
  frame.frame_id = 7;
  const DisparityImage result = matcher.Match(frame);
  EXPECT_EQ(result.frame_id, 7);
  std::vector<double> errors;
  int visible = 0;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      EXPECT_EQ(std::isnan(result.disparity_px(v, u)), std::isnan(result.sigma_px(v, u)));
      if (u - plane.At(u, v) < 0) continue;
      ++visible;
      if (!std::isnan(result.disparity_px(v, u)))
        errors.push_back(std::abs(result.disparity_px(v, u) - plane.At(u, v)));
    }
  EXPECT_GT(static_cast<double>(errors.size()), 0.9 * visible);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.25);
}

TEST(DisparityMatcherTest, RefusesImagesOfUnequalSize) {
  DisparityMatcher matcher{DisparityConfig{}};
  StereoFrame frame;
  frame.left.create(20, 20);
  frame.right.create(20, 21);
  EXPECT_THROW(matcher.Match(frame), CheckError);
}

}  // namespace
}  // namespace terrace
