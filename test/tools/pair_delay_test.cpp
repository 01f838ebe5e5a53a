// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pair_delay.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

constexpr int kViewWidth = 320, kViewHeight = 240;
constexpr double kFrameS = 1.0 / 15.0;
constexpr double kDisparityOfWallPx = 9.0;

StereoCamera Viewer() { return {kViewWidth, kViewHeight, 250.0, 250.0, 159.5, 119.5, 0.1}; }

/// A wall of smooth random grey, larger than the view.
cv::Mat1b Wall(unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat1b wall(500, 500);
  for (std::uint8_t& value : wall) value = static_cast<std::uint8_t>(random());
  cv::GaussianBlur(wall, wall, {}, 2.0);
  cv::normalize(wall, wall, 20, 235, cv::NORM_MINMAX);
  return wall;
}

/// How far the view has gone up at a time, as of a body that pitches while it walks [px].
double RowsAt(double t_s) { return 9.0 * std::sin(2.0 * M_PI * 1.1 * t_s); }

cv::Mat1b ViewOf(const cv::Mat1b& wall, double u, double v) {
  cv::Mat1b view;
  cv::getRectSubPix(wall, {kViewWidth, kViewHeight},
                    cv::Point2f(static_cast<float>(250.0 + u), static_cast<float>(250.0 + v)), view);
  return view;
}

/// A frame whose right camera is late and, all the time, by some rows too low.
StereoFrame FrameAt(const cv::Mat1b& wall, int i, double delay_s, double rows_off_px) {
  StereoFrame frame;
  const double t_s = i * kFrameS;
  frame.t_capture.ns = 1'000'000'000 + std::llround(1e9 * t_s);
  frame.left = ViewOf(wall, 0.0, -RowsAt(t_s));
  frame.right = ViewOf(wall, kDisparityOfWallPx, -RowsAt(t_s + delay_s) - rows_off_px);
  return frame;
}

PairDelay DelayOf(unsigned seed, double delay_s, double rows_off_px) {
  const cv::Mat1b wall = Wall(seed);
  std::vector<MovingRowMatch> moving;
  RowMatchConfig config;
  config.max_disparity_px = 40;
  std::vector<StereoFrame> frames;
  for (int i = 0; i < 11; ++i) frames.push_back(FrameAt(wall, i, delay_s, rows_off_px));
  for (std::size_t i = 2; i + 2 < frames.size(); ++i) {
    const auto found =
        FollowMatches(MatchAcrossRows(frames[i], config),
                      {&frames[i - 2], &frames[i - 1], &frames[i], &frames[i + 1], &frames[i + 2]});
    moving.insert(moving.end(), found.begin(), found.end());
  }
  return EstimateDelay(moving, Viewer());
}

TEST(PairDelayTest, MeasuresByHowMuchTheRightCameraIsLate) {
  for (const double delay_s : {0.001, 0.03, -0.01}) {
    for (const double rows_off_px : {0.0, 1.5}) {
      const PairDelay delay = DelayOf(101, delay_s, rows_off_px);
      std::printf("%.1f ms late, %.1f rows low: %.2f +- %.2f ms from %d points\n", 1e3 * delay_s, rows_off_px,
                  1e3 * delay.delay_s, 1e3 * delay.sigma_s, delay.num_matches);
      EXPECT_TRUE(delay.told());
      EXPECT_NEAR(delay.delay_s, delay_s, 0.0002 + 0.02 * std::abs(delay_s));
      EXPECT_NEAR(delay.delay_s, delay_s, 0.0001 + 3.0 * delay.sigma_s) << "as sure as it says";
    }
  }
}

TEST(PairDelayTest, SaysThatItCannotTellWhileNothingMoves) {
  const cv::Mat1b wall = Wall(7);
  std::array<StereoFrame, MovingRowMatch::kNumFrames> still;
  std::array<const StereoFrame*, MovingRowMatch::kNumFrames> frames{};
  for (std::size_t i = 0; i < still.size(); ++i) {
    still[i] = FrameAt(wall, 0, 0.0, 1.0);
    still[i].t_capture.ns += static_cast<std::int64_t>(i) * 66'000'000;
    frames[i] = &still[i];
  }
  const auto moving = FollowMatches(MatchAcrossRows(still[2]), frames);
  EXPECT_GE(moving.size(), 20u);
  EXPECT_FALSE(EstimateDelay(moving, Viewer()).told());
  EXPECT_FALSE(EstimateDelay({}, Viewer()).told());
}

}  // namespace
}  // namespace terrace
