// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/path_aggregation.h"

#include <random>

#include <gtest/gtest.h>

#include "test/every_target.h"
#include "test/stereo/plain_matcher.h"
#include "test/stereo/textured_pair.h"

namespace terrace {
namespace {

struct Case {
  int width, height, num_disparities;
  bool ranges_differ;
  int num_paths = 4;
};

class PathAggregationTest : public testing::TestWithParam<Case> {};

TEST_P(PathAggregationTest, GivesTheSumsOfThePlainMatcherOnEveryTarget) {
  const Case c = GetParam();
  StereoFrame frame = RenderPlane(c.width, c.height, {5.0, 0.05, 0.1});
  cv::Mat_<std::int16_t> first(c.height, c.width, static_cast<std::int16_t>(0));
  if (c.ranges_differ) {
    std::mt19937 random(3);
    for (auto& f : first) f = static_cast<std::int16_t>(random() % 4 == 0 ? random() % 100 : 3);
  }
  const PathPenalties penalties = {6, 40, 16};
  const PlainMatcher plain(frame.left, frame.right, Census9x7(), penalties, first, c.num_disparities);

  CensusImage left, right;
  left.Compute(frame.left, Census9x7());
  right.Compute(frame.right, Census9x7());
  StepPenalties step_penalties;
  step_penalties.Compute(frame.left, penalties, c.num_paths == 8);
  DisparityRanges ranges;
  if (c.ranges_differ)
    ranges.Set(first);
  else
    ranges.Set(c.width, c.height, 0);
  const MatchingProblem problem{&left, &right, &ranges, &step_penalties, penalties.p1, nullptr, c.num_paths};
  for (const Strip& strip : {Strip{0, 9, 2, c.num_disparities}, Strip{9, c.height, 3, c.num_disparities}}) {
    const std::vector<int> expected = plain.Sums(strip.top, strip.bottom, strip.lead_in, c.num_paths);
    OnEveryTarget([&] {
      PathAggregator aggregator;
      int next_row = strip.top;
      aggregator.Aggregate(problem, strip, [&](int v, const std::uint8_t* sums) {
        EXPECT_EQ(v, next_row++);
        for (int u = 0; u < c.width; ++u)
          for (int i = 0; i < c.num_disparities; ++i)
            ASSERT_EQ(sums[u * c.num_disparities + c.num_disparities - 1 - i], expected[plain.At(u, v, i)])
                << "u " << u << ", v " << v << ", disparity " << first(v, u) + i;
      });
      EXPECT_EQ(next_row, strip.bottom);
    });
  }
}

std::vector<Case> Cases() {
  std::vector<Case> cases;
  for (const int num_paths : {2, 4, 8})
    for (const Case& c :
         {Case{40, 20, 16, false}, Case{33, 20, 32, false}, Case{50, 21, 64, false}, Case{21, 12, 128, false},
          Case{17, 12, 208, false}, Case{37, 20, 16, true}, Case{64, 20, 16, true}, Case{37, 20, 32, true}})
      cases.push_back({c.width, c.height, c.num_disparities, c.ranges_differ, num_paths});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Sizes, PathAggregationTest, testing::ValuesIn(Cases()));

}  // namespace
}  // namespace terrace
