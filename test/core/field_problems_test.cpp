// SPDX-License-Identifier: BSD-3-Clause
#include "core/field_problems.h"

#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(FieldProblemsTest, NamesFieldValueAndRuleWhateverTheFieldHolds) {
  FieldProblems problems;
  problems.Require(false, "paths", 3, "be 2, 4 or 8");
  problems.Require(false, "tier", std::string("best"), "be fast or quality");
  problems.Require(false, "url", std::string(), "read provider://address");
  problems.Require(false, "position_m", std::vector<double>{0.5, -1.0}, "hold x, y and z");
  EXPECT_THAT(
      problems.Take(),
      ElementsAre("paths = 3 must be 2, 4 or 8", "tier = \"best\" must be fast or quality",
                  "url = \"\" must read provider://address", "position_m = [0.5, -1] must hold x, y and z"));
}

TEST(FieldProblemsTest, SaysNothingOfValuesThatKeepTheRule) {
  FieldProblems problems;
  problems.Require(true, "paths", 4, "be 2, 4 or 8");
  problems.RequireAbove("a", 0.1, 0.0);
  problems.RequireAtLeast("b", 0.0, 0.0);
  problems.RequireWithin("c", 1.0, 1.0, 2.0);
  problems.RequireWithin("c", 2.0, 1.0, 2.0);
  problems.RequireInside("d", 1.5, 1.0, 2.0);
  problems.RequireUpTo("e", 2.0, 1.0, 2.0);
  EXPECT_THAT(problems.Take(), IsEmpty());
}

TEST(FieldProblemsTest, TellsWhetherTheEndsOfARangeAreAllowed) {
  FieldProblems problems;
  problems.RequireAbove("a", 0.0, 0.0);
  problems.RequireAtLeast("b", -0.5, 0.0);
  problems.RequireWithin("c", 2.5, 1.0, 2.0);
  problems.RequireInside("d", 1.0, 1.0, 2.0);
  problems.RequireInside("d", 2.0, 1.0, 2.0);
  problems.RequireUpTo("e", 1.0, 1.0, 2.0);
  EXPECT_THAT(problems.Take(),
              ElementsAre("a = 0 must be above 0", "b = -0.5 must be at least 0",
                          "c = 2.5 must lie between 1 and 2", "d = 1 must be above 1, below 2",
                          "d = 2 must be above 1, below 2", "e = 1 must be above 1, at most 2"));
}

TEST(FieldProblemsTest, TakesNoNumberForOneThatKeepsARule) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FieldProblems problems;
  problems.RequireAbove("a", nan, 0.0);
  problems.RequireAtLeast("b", nan, 0.0);
  problems.RequireWithin("c", nan, 1.0, 2.0);
  problems.RequireInside("d", nan, 1.0, 2.0);
  problems.RequireUpTo("e", nan, 1.0, 2.0);
  EXPECT_EQ(problems.Take().size(), 5U);
}

}  // namespace
}  // namespace terrace
