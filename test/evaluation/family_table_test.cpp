// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/family_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file_bytes.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string Place(const std::string& members) {
  return R"({"format": "terrace-evaluation", "version": 1)" + members + "}";
}

std::string Stairs(int risers_error, double riser_error_m) {
  return R"(, "staircases": {"num_true": 1, "num_result": 2, "num_found": 1, "matches": [{"num_risers_error": )" +
         std::to_string(risers_error) + R"(, "riser_error_m": )" + std::to_string(riser_error_m) +
         R"(, "tread_error_m": 0.004}]})";
}

TEST(FamilyTableTest, ShowsTheMeanAndTheWorstOfAFamily) {
  const std::string table = TableOfFamilies(
      {{"up",
        {Place(R"(, "feet": {"unsupported_pct": 0.5, "offered_pct": 90, "edge_bias_m": -0.004})"),
         Place(R"(, "feet": {"unsupported_pct": 1.5, "offered_pct": 98, "edge_bias_m": 0.002})")}}});
  EXPECT_THAT(table, HasSubstr("up             2 mean    1.00  94.00      -"));
  EXPECT_THAT(table, HasSubstr("worst   1.50  90.00      -"));
  EXPECT_THAT(table, HasSubstr(" -4.00"));                  // the bias farthest from zero
  EXPECT_THAT(table, Not(HasSubstr("all            2 ")));  // one family is all there is
}

TEST(FamilyTableTest, SumsUpStaircasesOfAllPlaces) {
  const std::string table =
      TableOfFamilies({{"up", {Place(Stairs(0, -0.002)), Place(Stairs(1, 0.012))}}, {"ramp", {Place("")}}});
  EXPECT_THAT(table,
              HasSubstr("2 of 2 found, 4 reported, 1 with all risers; riser 2.0 mm (max 12), tread 4.0 "
                        "mm (max 4)"));
  EXPECT_THAT(table, HasSubstr("0 of 0 found"));
  EXPECT_THAT(table, HasSubstr("all            3 mean"));
}

TEST(FamilyTableTest, CountsStairsTakenForARampAndRampsTakenForStairs) {
  const std::string table = TableOfFamilies(
      {{"up",
        {Place(
            R"(, "map": {"confusion_m2": {"stair_tread": {"ramp": 0.25, "missed": 1}, "stair_riser": {"ramp": 0.5},
               "ramp": {"stair_tread": 0.125}}})")}}});
  EXPECT_THAT(table, HasSubstr("as ramp 0.75 m2, ramp as stairs 0.12 m2"));
}

TEST(FamilyTableTest, RefusesWhatIsNoEvaluation) {
  EXPECT_THROW(TableOfFamilies({{"up", {"{}"}}}), FileError);
  EXPECT_THROW(TableOfFamilies({{"up", {"no json"}}}), FileError);
}

}  // namespace
}  // namespace terrace
