// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/baseline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file_bytes.h"

namespace terrace {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Baseline Stored() {
  Baseline baseline;
  baseline.figures = {{"trajectory.ate_rmse_m", {true, 0.002, 0.1}},
                      {"map.coverage", {false, 0.01, 0.0}},
                      {"time.rate_hz", {false, 0.0, 0.0}}};
  baseline.sequences["stairs"] = {
      {"trajectory.ate_rmse_m", 0.010}, {"map.coverage", 0.9}, {"time.rate_hz", 10.0}};
  return baseline;
}

std::vector<std::string> WorseFor(double ate_m, double coverage, double rate_hz) {
  return Compare(
             Stored(),
             {{"stairs",
               {{"trajectory.ate_rmse_m", ate_m}, {"map.coverage", coverage}, {"time.rate_hz", rate_hz}}}},
             {})
      .worse;
}

TEST(BaselineTest, AllowsWhatIsBetterOrWithinTheTolerance) {
  // The larger of 2 mm and a tenth of 10 mm: 12 mm pass. A rate is shown only.
  EXPECT_THAT(WorseFor(0.0119, 0.891, 1.0), IsEmpty());
  EXPECT_THAT(WorseFor(0.001, 1.0, 100.0), IsEmpty());
}

TEST(BaselineTest, NamesWhatGotWorseBeyondTheTolerance) {
  EXPECT_THAT(WorseFor(0.0121, 0.9, 10.0),
              ElementsAre(HasSubstr("trajectory.ate_rmse_m was 0.0100 and is 0.0121")));
  EXPECT_THAT(WorseFor(0.01, 0.88, 10.0), ElementsAre(HasSubstr("map.coverage")));
}

TEST(BaselineTest, TakesAMissingFigureAndAFailedRunForWorse) {
  const BaselineComparison gone = Compare(Stored(), {{"stairs", {{"map.coverage", 0.9}}}}, {});
  EXPECT_THAT(gone.worse, ElementsAre(HasSubstr("no longer measured")));
  EXPECT_THAT(Compare(Stored(), {}, {"stairs"}).worse, ElementsAre("stairs: failed"));
}

TEST(BaselineTest, ShowsANewSequenceWithoutJudgingIt) {
  const BaselineComparison comparison = Compare(Stored(), {{"ramp", {{"map.coverage", 0.1}}}}, {});
  EXPECT_THAT(comparison.worse, IsEmpty());
  EXPECT_THAT(comparison.table, HasSubstr("ramp"));
}

TEST(BaselineTest, ComesBackFromItsFile) {
  const Baseline back = ParseBaseline(ToJson(Stored()), "baseline.json");
  EXPECT_EQ(back.sequences, Stored().sequences);
  ASSERT_EQ(back.figures.size(), 3u);
  EXPECT_EQ(back.figures[0].path, "trajectory.ate_rmse_m");
  EXPECT_TRUE(back.figures[0].tolerance.lower_is_better);
  EXPECT_EQ(back.figures[1].tolerance.absolute, 0.01);
  EXPECT_FALSE(back.figures[2].tolerance.judged());
  EXPECT_THROW(ParseBaseline("{\"format\": \"other\"}", "baseline.json"), FileError);
}

TEST(BaselineTest, PicksFiguresByTheirPath) {
  const Figures figures =
      FiguresOf(R"({"trajectory": {"ate_rmse_m": null}, "map": {"coverage": 0.5}})", "x", Stored().figures);
  EXPECT_EQ(figures, (Figures{{"map.coverage", 0.5}}));
}

}  // namespace
}  // namespace terrace
