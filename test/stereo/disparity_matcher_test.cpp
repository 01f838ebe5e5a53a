// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "core/check.h"
#include "test/every_target.h"
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
  config.paths = 3;
  config.large_step_penalty = 51;
  config.prior_full_every_frames = 0;
  EXPECT_THAT(
      config.Problems(),
      ElementsAre(HasSubstr("max_disparity_px = 100"), HasSubstr("tier = \"best\""), HasSubstr("paths = 3"),
                  HasSubstr("large_step_penalty = 51"), HasSubstr("prior_full_every_frames")));
  EXPECT_THROW(DisparityMatcher{config}, std::invalid_argument);
}

TEST(DisparityConfigTest, AutoSearchesAsFarAsTheNearestDistanceNeeds) {
  DisparityConfig config;
  config.max_disparity_px = std::nullopt;
  config.nearest_m = 0.4;
  EXPECT_TRUE(config.Problems().empty());
  StereoCamera camera;
  camera.fx = 400;
  camera.baseline_m = 0.12;
  EXPECT_EQ(config.ForCamera(camera).max_disparity_px, 128);  // 120 px
  camera.fx = 700;
  EXPECT_EQ(config.ForCamera(camera).max_disparity_px, 224);  // 210 px
  camera.fx = 2000;
  EXPECT_EQ(config.ForCamera(camera).max_disparity_px, 256);  // 600 px, and no more is searched
  config.max_disparity_px = 64;
  EXPECT_EQ(config.ForCamera(camera).max_disparity_px, 64);
  config.max_disparity_px = std::nullopt;
  EXPECT_THROW(DisparityMatcher{config}, std::invalid_argument);
}

DisparityConfig Tier(const std::string& tier, int max_disparity_px) {
  DisparityConfig config;
  config.tier = tier;
  config.max_disparity_px = max_disparity_px;
  return config;
}

bool SameBits(const DisparityImage& a, const DisparityImage& b) {
  const auto same = [](const cv::Mat1f& x, const cv::Mat1f& y) {
    return x.size() == y.size() && std::memcmp(x.data, y.data, x.total() * sizeof(float)) == 0;
  };
  return same(a.disparity_px, b.disparity_px) && same(a.sigma_px, b.sigma_px);
}

class DisparityMatcherTest : public testing::TestWithParam<std::string> {};

/// A board before a wall at 12 px, with texture that is like itself nowhere else.
StereoFrame BoardBeforeWall(const cv::Rect& in_left, int board_px) {
  const StereoFrame wall = RenderPlane(480, 320, {12.0});
  StereoFrame frame;
  frame.left = wall.left.clone();
  frame.right = wall.right.clone();
  std::mt19937 random(5);
  for (int v = in_left.y; v < in_left.br().y; v += 2)
    for (int u = in_left.x; u < in_left.br().x; u += 2) {
      const auto grey = static_cast<std::uint8_t>(40 + random() % 160);
      for (const cv::Point& step : {cv::Point(0, 0), cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1)}) {
        const cv::Point pixel = cv::Point(u, v) + step;
        frame.left(pixel) = grey;
        frame.right(pixel - cv::Point(board_px, 0)) = grey;
      }
    }
  return frame;
}

TEST_P(DisparityMatcherTest, LeavesUnknownWhatIsNearerThanTheSearchGoes) {
  const cv::Rect in_left(200, 80, 160, 160);
  // More is searched than 48, so that the board is found and left out; not so with 64.
  for (const auto& [range, board_px] : {std::pair(48, 60), std::pair(64, 100)}) {
    const DisparityImage result =
        DisparityMatcher(Tier(GetParam(), range)).Match(BoardBeforeWall(in_left, board_px));
    int num_on_board = 0, num_on_wall = 0;
    for (int v = 0; v < 320; ++v)
      for (int u = 20; u < 480; ++u) {
        const bool known = !std::isnan(result.disparity_px(v, u));
        EXPECT_FALSE(result.disparity_px(v, u) > static_cast<float>(range));
        num_on_board += known && in_left.contains({u, v});
        num_on_wall += known && u > 380;
      }
    EXPECT_LT(num_on_board, 0.1 * in_left.area()) << range;  // at its edges the wall's texture reaches in
    EXPECT_GT(num_on_wall, 0.95 * 320 * 99) << range;
    EXPECT_GT(result.no_match_share + result.limit_share, 0.1) << range;
  }
  EXPECT_LT(DisparityMatcher(Tier(GetParam(), 128)).Match(BoardBeforeWall(in_left, 60)).limit_share, 0.002);
}

TEST_P(DisparityMatcherTest, FindsAPlaneWhenTheRightRowsAreOff) {
  const SlantedPlane plane{8.3, 0.01, 0.05};
  const StereoFrame aligned = RenderPlane(480, 360, plane);
  StereoFrame off = aligned;
  off.right = cv::Mat1b();
  StraightenRows(aligned.right, {.centre_px = -1.2f, .per_column = 0.003f}, off.right);
  const auto rms = [&](const StereoFrame& frame, bool straighten) {
    DisparityConfig config = Tier(GetParam(), 64);
    config.straighten_rows = straighten;
    const DisparityImage result = DisparityMatcher(config).Match(frame);
    double squares = 0.0;
    int count = 0;
    for (int v = 10; v < 350; ++v)
      for (int u = 60; u < 470; ++u)
        if (!std::isnan(result.disparity_px(v, u)))
          squares += std::pow(result.disparity_px(v, u) - plane.At(u, v), 2), ++count;
    EXPECT_GT(count, 100000);
    return std::sqrt(squares / count);
  };
  EXPECT_LT(rms(off, true), 1.5 * rms(aligned, true));
  EXPECT_GT(rms(off, false), 3.0 * rms(off, true));  // what it is for
}

TEST_P(DisparityMatcherTest, KnowsHowWrongAPairMayBeWhoseRowsAndColumnsAreOff) {
  // The columns are off by a fifth of a pixel, which nothing shows, and so are the rows, which can be seen.
  constexpr double kOff_px = 0.2;
  const SlantedPlane plane{8.3, 0.01, 0.05};
  const StereoFrame straight = RenderPlane(480, 360, {plane.d0 + kOff_px, plane.du, plane.dv});
  StereoFrame off = straight;
  off.right = cv::Mat1b();
  StraightenRows(straight.right, {.centre_px = -kOff_px}, off.right);
  const auto ratio = [&](const StereoFrame& frame) {  // of errors to sigma, 68 % quantile
    const DisparityImage result = DisparityMatcher(Tier(GetParam(), 64)).Match(frame);
    std::vector<double> ratios;
    for (int v = 10; v < 350; ++v)
      for (int u = 60; u < 470; ++u)
        if (!std::isnan(result.disparity_px(v, u)))
          ratios.push_back(std::abs(result.disparity_px(v, u) - plane.At(u, v)) /
                           result.TotalSigma(v * result.sigma_px.cols + u));
    std::nth_element(ratios.begin(), ratios.begin() + ratios.size() * 68 / 100, ratios.end());
    return ratios[ratios.size() * 68 / 100];
  };
  EXPECT_GT(ratio(off), 0.8);
  EXPECT_LT(ratio(off), 1.3);
  EXPECT_GT(ratio(straight), 2.0);  // what straight rows do not show
}

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

TEST_P(DisparityMatcherTest, FindsAPlaneAlongAnyNumberOfPathsWithTheSameBitsForAnyNumberOfThreads) {
  const SlantedPlane plane{8.3, 0.01, 0.05};
  const StereoFrame frame = RenderPlane(160, 161, plane);
  std::vector<DisparityImage> results;
  for (const int paths : {2, 4, 8}) {
    DisparityConfig config = Tier(GetParam(), 32);
    config.paths = paths;
    results.push_back(DisparityMatcher(config).Match(frame));
    for (const int num_threads : {1, 4}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, num_threads);
      EXPECT_TRUE(SameBits(DisparityMatcher(config).Match(frame), results.back())) << paths << " paths";
    }
    int num_right = 0;
    const cv::Rect inner(32, 8, 120, 145);
    for (int v = inner.y; v < inner.br().y; ++v)
      for (int u = inner.x; u < inner.br().x; ++u)
        num_right += std::abs(results.back().disparity_px(v, u) - plane.At(u, v)) < 0.5;
    EXPECT_GT(num_right, 0.97 * inner.area()) << paths << " paths";
  }
  EXPECT_FALSE(SameBits(results[0], results[1]));
  EXPECT_FALSE(SameBits(results[1], results[2]));
}

TEST_P(DisparityMatcherTest, LeavesResultsAloneThatSomebodyStillHolds) {
  DisparityMatcher matcher(Tier(GetParam(), 32));
  const DisparityImage first = matcher.Match(RenderPlane(96, 64, {8.3, 0.01, 0.05}));
  const cv::Mat1f disparity = first.disparity_px.clone(), sigma = first.sigma_px.clone();
  for (int i = 0; i < 20; ++i) matcher.Match(RenderPlane(96, 64, {5.0 + i, 0.0, 0.0}));
  EXPECT_EQ(std::memcmp(disparity.data, first.disparity_px.data, disparity.total() * sizeof(float)), 0);
  EXPECT_EQ(std::memcmp(sigma.data, first.sigma_px.data, sigma.total() * sizeof(float)), 0);
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

TEST_P(DisparityMatcherTest, FindsAPlaneSoNearThatItsDisparitiesAreBeyond256) {
  const SlantedPlane plane{300.3, 0.02, 0.3};
  const DisparityImage result =
      DisparityMatcher(Tier(GetParam(), 400)).Match(RenderPlane(801, 241, plane));  // to 388 px; odd sizes
  EXPECT_EQ(result.range_px, 400.0f);
  int num_known = 0, num_right = 0, num_beyond = 0;
  for (int v = 8; v < 233; ++v)
    for (int u = 400; u < 790; ++u) {
      const float d = result.disparity_px(v, u), sigma = result.sigma_px(v, u);
      EXPECT_EQ(std::isnan(d), std::isnan(sigma));
      num_known += !std::isnan(d);
      num_right += std::abs(d - plane.At(u, v)) < std::max(3.0f * sigma, 0.5f);
      num_beyond += d > 400.0f;
    }
  EXPECT_GT(num_known, 0.97 * 225 * 390);
  EXPECT_GT(num_right, 0.97 * num_known);
  EXPECT_EQ(num_beyond, 0);
}

TEST_P(DisparityMatcherTest, RefusesImagesOfUnequalSize) {
  DisparityMatcher matcher(Tier(GetParam(), 32));
  StereoFrame frame;
  frame.left.create(20, 20);
  frame.right.create(20, 21);
  EXPECT_THROW(matcher.Match(frame), CheckError);
}

/// A prior that says the same of the whole image.
DisparityPrior Everywhere(const StereoFrame& frame, float low_px, float high_px) {
  DisparityPrior prior(frame.left.cols, frame.left.rows);
  for (DisparityPrior::Range& tile : prior.tiles) tile = {low_px, high_px};
  return prior;
}

DisparityConfig WithPrior(const std::string& tier, int full_every_frames) {
  DisparityConfig config = Tier(tier, 128);
  config.use_prior = true;
  config.prior_full_every_frames = full_every_frames;
  return config;
}
constexpr int kNever = 1000000;

TEST_P(DisparityMatcherTest, ARightPriorChangesLittle) {
  StereoFrame frame = RenderPlane(300, 160, {50.0, 0.01, 0.02});
  frame.frame_id = 1;  // the turn of none of the strips
  const DisparityPrior prior = Everywhere(frame, 50.0f, 57.0f);
  const DisparityImage with = DisparityMatcher(WithPrior(GetParam(), kNever)).Match(frame, &prior);
  const DisparityImage without = DisparityMatcher(Tier(GetParam(), 128)).Match(frame);
  int num_known = 0, num_differ = 0;
  for (int i = 0; i < static_cast<int>(frame.left.total()); ++i) {
    num_known += !std::isnan(without.disparity_px(i));
    num_differ += !(std::abs(with.disparity_px(i) - without.disparity_px(i)) < 0.1f) &&
                  !std::isnan(without.disparity_px(i));
  }
  EXPECT_LT(num_differ, 0.02 * num_known);
}

TEST_P(DisparityMatcherTest, AWrongPriorChangesNothing) {
  // What is searched is wider than the prior, but not so wide that it holds the plane.
  for (const auto& [low_px, plane_px] : {std::pair(0.0f, 80.0), std::pair(90.0f, 50.0)}) {
    StereoFrame frame = RenderPlane(300, 160, {plane_px, 0.01, 0.02});
    frame.frame_id = 1;
    const DisparityImage without = DisparityMatcher(Tier(GetParam(), 128)).Match(frame);
    const DisparityPrior prior = Everywhere(frame, low_px, low_px + 5.0f);
    EXPECT_TRUE(SameBits(DisparityMatcher(WithPrior(GetParam(), kNever)).Match(frame, &prior), without));
  }
}

TEST_P(DisparityMatcherTest, IgnoresAPriorThatTheSettingsDoNotAskFor) {
  const StereoFrame frame = RenderPlane(160, 96, {20.0, 0.01, 0.02});
  const DisparityPrior prior = Everywhere(frame, 18.0f, 24.0f);
  EXPECT_TRUE(SameBits(DisparityMatcher(Tier(GetParam(), 128)).Match(frame, &prior),
                       DisparityMatcher(Tier(GetParam(), 128)).Match(frame)));
}

/// A wall at 8 px with a square of `side` pixels at 72 px before it.
StereoFrame WallWithSquare(int side) {
  StereoFrame frame = RenderPlane(300, 160, {8.0, 0.0, 0.0});
  const StereoFrame near = RenderPlane(300, 160, {72.0, 0.0, 0.0}, {}, 5);
  const cv::Rect in_left(180, 80, side, side), in_right(180 - 72, 80, side, side);
  near.left(in_left).copyTo(frame.left(in_left));
  near.right(in_right).copyTo(frame.right(in_right));
  return frame;
}

bool FindsSquare(const DisparityImage& image, int side) {
  return std::abs(image.disparity_px(80 + side / 2, 180 + side / 2) - 72.0f) < 1.0f;
}

TEST_P(DisparityMatcherTest, FindsWhatIsNewAndNearAtOnceWhenItFillsATile) {
  StereoFrame frame = WallWithSquare(64);
  frame.frame_id = 1;
  const DisparityPrior prior = Everywhere(frame, 8.0f, 8.0f);
  EXPECT_TRUE(FindsSquare(DisparityMatcher(WithPrior(GetParam(), kNever)).Match(frame, &prior), 64));
}

TEST_P(DisparityMatcherTest, FindsWhatIsNewAndSmallWhenTheTurnComesAndNotBefore) {
  constexpr int kFullEvery = 4, kSide = 24;
  StereoFrame frame = WallWithSquare(kSide);
  DisparityMatcher matcher(WithPrior(GetParam(), kFullEvery));
  ASSERT_TRUE(FindsSquare(matcher.Match(frame), kSide)) << "without a prior";
  const DisparityPrior prior = Everywhere(frame, 8.0f, 8.0f);
  int num_found = 0;
  for (frame.frame_id = 5; frame.frame_id < 5 + kFullEvery; ++frame.frame_id)
    num_found += FindsSquare(matcher.Match(frame, &prior), kSide);
  EXPECT_EQ(num_found, 1);
}

TEST_P(DisparityMatcherTest, GivesTheSameBitsWithAPriorForAnyNumberOfThreadsAndOnEveryTarget) {
  StereoFrame frame = WallWithSquare(40);
  frame.frame_id = 3;
  const DisparityPrior prior = Everywhere(frame, 6.0f, 9.0f);
  const auto match = [&] { return DisparityMatcher(WithPrior(GetParam(), 16)).Match(frame, &prior); };
  const DisparityImage first = match();
  for (const int num_threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, num_threads);
    EXPECT_TRUE(SameBits(match(), first));
  }
  OnEveryTarget([&] { EXPECT_TRUE(SameBits(match(), first)); });
}

TEST_P(DisparityMatcherTest, MatchesNothingButTheRegionOfInterest) {
  const StereoFrame frame = RenderPlane(300, 161, {20.0, 0.01, 0.05});
  DisparityConfig config = Tier(GetParam(), 64);
  const DisparityImage whole = DisparityMatcher(config).Match(frame);
  config.roi_left_px = 171;
  config.roi_top_px = 57;
  config.roi_width_px = 81;
  config.roi_height_px = 60;
  const DisparityImage part = DisparityMatcher(config).Match(frame);
  ASSERT_EQ(part.disparity_px.size(), frame.left.size());
  const cv::Rect region(171, 57, 81, 60);
  int num_differ = 0;
  for (int v = 0; v < frame.left.rows; ++v)
    for (int u = 0; u < frame.left.cols; ++u) {
      ASSERT_EQ(std::isnan(part.disparity_px(v, u)), std::isnan(part.sigma_px(v, u)));
      if (!region.contains({u, v}))
        ASSERT_TRUE(std::isnan(part.disparity_px(v, u)));
      else if (!(std::abs(part.disparity_px(v, u) - whole.disparity_px(v, u)) < 0.05f))
        ++num_differ;
    }
  EXPECT_LT(num_differ, 0.02 * region.area());
}

TEST_P(DisparityMatcherTest, CutsARegionOfInterestAtTheImage) {
  const StereoFrame frame = RenderPlane(160, 120, {8.3, 0.01, 0.05});
  DisparityConfig config = Tier(GetParam(), 32);
  const DisparityImage whole = DisparityMatcher(config).Match(frame);
  config.roi_width_px = config.roi_height_px = 2000000000;
  EXPECT_TRUE(SameBits(DisparityMatcher(config).Match(frame), whole));
  config.roi_left_px = 150;  // what remains is narrower than an image may be
  EXPECT_FALSE(std::isnan(DisparityMatcher(config).Match(frame).disparity_px(60, 155)));
  config.roi_top_px = 120;
  for (const float d : DisparityMatcher(config).Match(frame).disparity_px) ASSERT_TRUE(std::isnan(d));
}

TEST_P(DisparityMatcherTest, UsesAPriorInARegionOfInterest) {
  StereoFrame frame = RenderPlane(300, 160, {50.0, 0.01, 0.02});
  frame.frame_id = 1;
  DisparityPrior prior = Everywhere(frame, 0.0f, 0.0f);  // wrong outside
  for (int row = 0; row < prior.rows; ++row)
    for (int column = 1; column < prior.columns; ++column) prior.At(row, column) = {50.0f, 57.0f};
  DisparityConfig config = WithPrior(GetParam(), kNever);
  config.roi_left_px = 240;
  const DisparityImage found = DisparityMatcher(config).Match(frame, &prior);
  EXPECT_NEAR(found.disparity_px(80, 270), 50.0 + 2.7 + 1.6, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Tiers, DisparityMatcherTest, testing::Values("fast", "quality"),
                         [](const auto& tier) { return tier.param; });

}  // namespace
}  // namespace terrace
