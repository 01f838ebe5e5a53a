// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/line_fit.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(LineFitTest, FindsTheLineThroughValuesOfTwoKindsThatLieApart) {
  std::vector<LineValue> values;
  for (int k = 0; k <= 2; ++k) values.push_back({1.0 * k, 1.0 + 0.17 * k, 0.006});
  // Of the second kind all are lower alike, and they are seen where the first kind is not.
  for (int k = 3; k <= 6; ++k) values.push_back({1.0 * k, 1.0 + 0.17 * k - 0.03, 0.006, 1.0, 0.1});
  const auto fit = FitLine(values);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->slope, 0.17, 0.0005);
  EXPECT_NEAR(fit->at_zero, 1.0, 0.001);
}

TEST(LineFitTest, HoldsAnOffsetForSmallThatIsKnownToBeSmall) {
  std::vector<LineValue> values{{0.0, 0.0, 0.006}, {2.0, 0.34, 0.006, 1.0, 0.001}};
  const auto fit = FitLine(values);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->slope, 0.17, 1e-9);
  values[1].offset_sigma = 0.05;
  EXPECT_GT(FitLine(values)->slope_sigma, 5.0 * fit->slope_sigma) << "all of it may be offset";
}

TEST(LineFitTest, KnowsTheSlopeAsWellAsItsSigmaSays) {
  constexpr int kTrials = 300;
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  double sum2 = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double offset = 0.02 * normal(generator);
    std::vector<LineValue> values;
    for (int k = 0; k < 4; ++k) values.push_back({1.0 * k, 0.3 * k + 0.006 * normal(generator), 0.006});
    for (int k = 3; k < 7; ++k)
      values.push_back({1.0 * k, 0.3 * k + offset + 0.015 * normal(generator), 0.015, 1.0, 0.02});
    const auto fit = FitLine(values);
    ASSERT_TRUE(fit);
    sum2 += std::pow((fit->slope - 0.3) / fit->slope_sigma, 2);
  }
  const double rms = std::sqrt(sum2 / kTrials);
  EXPECT_GT(rms, 0.75);
  EXPECT_LT(rms, 1.15);
}

TEST(LineFitTest, CountsFragmentsAsTheOneThingThatTheyAre) {
  const auto whole = FitLine({{0.0, 0.0, 0.01}, {1.0, 0.2, 0.01}});
  const auto pieces = FitLine({{0.0, 0.0, 0.01}, {1.0, 0.2, 0.01, 0.5}, {1.0, 0.2, 0.01, 0.5}});
  ASSERT_TRUE(whole && pieces);
  EXPECT_NEAR(pieces->slope_sigma, whole->slope_sigma, 1e-9);
}

TEST(LineFitTest, TellsNoSlopeByValuesAtOnePlace) {
  EXPECT_FALSE(FitLine({}));
  EXPECT_FALSE(FitLine({{1.0, 0.2, 0.01}, {1.0, 0.21, 0.01}}));
}

}  // namespace
}  // namespace terrace
