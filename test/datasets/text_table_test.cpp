// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/text_table.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temporary_folder.h"

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Table<double> ReadNumbers(const std::string& text, char separator = ',') {
  const TemporaryFolder folder;
  WriteText(folder.path() / "table.csv", text);
  return ReadTable<double>(folder.path() / "table.csv", separator, "two numbers",
                           [](std::span<const std::string_view> cells) -> std::optional<double> {
                             const auto v = ParseDoubles(cells, 0, 2);
                             return v ? std::optional((*v)[1]) : std::nullopt;
                           });
}

TEST(ParseTest, TakesWholeCellsOnly) {
  EXPECT_EQ(ParseDouble("1.5e3"), 1500.0);
  EXPECT_EQ(ParseDouble("+2"), 2.0);
  EXPECT_EQ(ParseDouble("1.5x"), std::nullopt);
  EXPECT_EQ(ParseDouble(""), std::nullopt);
  EXPECT_EQ(ParseDouble("nan"), std::nullopt);
  EXPECT_EQ(ParseDouble("inf"), std::nullopt);
  EXPECT_EQ(ParseInt64("1403636584763555584"), 1403636584763555584);
  EXPECT_EQ(ParseInt64("14036365847635555840"), std::nullopt);
  EXPECT_EQ(ParseInt64("1.0"), std::nullopt);
}

TEST(TableTest, SkipsCommentsEmptyLinesAndAHeading) {
  const Table<double> table = ReadNumbers("a, b\n#x\n\n 1 , 2 \r\n3,4");
  EXPECT_THAT(table.rows, ElementsAre(2, 4));
  EXPECT_THAT(table.warnings, IsEmpty());
  EXPECT_EQ(table.problem, "");
}

TEST(TableTest, CutsAtAnyRunOfBlanks) {
  EXPECT_THAT(ReadNumbers("1   2\n\t3 \t 4  \n", ' ').rows, ElementsAre(2, 4));
}

TEST(TableTest, LeavesOutBadLinesAndNamesTheFirst) {
  const Table<double> table = ReadNumbers("1,2\nrubbish\n3,4\n5\n");
  EXPECT_THAT(table.rows, ElementsAre(2, 4));
  EXPECT_THAT(table.warnings,
              ElementsAre(HasSubstr(
                  "table.csv: 2 lines left out, the first is line 2: a line must hold two numbers")));
}

TEST(TableTest, SaysThatNothingWasThere) {
  EXPECT_THAT(ReadNumbers("").problem, HasSubstr("table.csv: no line holds two numbers"));
  EXPECT_THAT(ReadNumbers("#only a heading\n").problem, HasSubstr("no line holds two numbers"));
  EXPECT_THAT(ReadNumbers("only a heading").problem, HasSubstr("no line holds two numbers"));
}

TEST(TableTest, SurvivesLinesWithAMillionColumnsAndBinaryRubbish) {
  std::string wide;
  for (int i = 0; i < 1'000'000; ++i) wide += "1,";
  EXPECT_THAT(ReadNumbers("1,2\n" + wide + "\n3,4\n").rows, ElementsAre(2, 4));
  EXPECT_THAT(ReadNumbers(wide).problem, HasSubstr("no line holds"));
  EXPECT_THAT(ReadNumbers(std::string("1,2\n\0\xff\x80,\0\n3,4\n", 13)).rows, ElementsAre(2, 4));
}

TEST(TableTest, AByteOrderMarkCostsNoRow) {
  EXPECT_THAT(ReadNumbers("\xEF\xBB\xBF"
                          "1,2\n3,4\n")
                  .rows,
              ElementsAre(2, 4));
}

TEST(KeepRisingTest, LeavesOutOneWildTimeAndNotAllThatFollow) {
  const auto kept = [](std::vector<std::int64_t> times) {
    const std::size_t num_times = times.size();
    const std::int64_t num_left_out = KeepRising(&times, [](std::int64_t ns) { return Timestamp{ns}; });
    EXPECT_EQ(times.size() + static_cast<std::size_t>(num_left_out), num_times);
    return times;
  };
  EXPECT_THAT(kept({1, 2, 3}), ElementsAre(1, 2, 3));
  EXPECT_THAT(kept({1, 999, 2, 3}), ElementsAre(1, 2, 3));
  EXPECT_THAT(kept({5, 6, 1, 7, 8}), ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(kept({1, 1, 2, 2}), ElementsAre(1, 2));
  EXPECT_THAT(kept({}), ElementsAre());
}

OrderedRows Ordered(std::vector<std::int64_t>* times_ns) {
  return OrderByTime(times_ns, [](std::int64_t ns) { return Timestamp{ns}; });
}

TEST(OrderByTimeTest, MovesRowsToWhereTheirTimesLeaveAGap) {
  std::vector<std::int64_t> sorted;
  for (int i = 0; i < 40; ++i) sorted.push_back(100 * i);
  std::vector<std::int64_t> times = sorted;
  std::rotate(times.begin() + 5, times.begin() + 6, times.begin() + 8);
  std::swap(times[20], times[21]);
  std::swap(times[0], times[1]);
  const OrderedRows ordered = Ordered(&times);
  EXPECT_EQ(times, sorted);
  EXPECT_EQ(ordered.num_moved, 3);
  EXPECT_EQ(ordered.num_left_out, 0);
}

TEST(OrderByTimeTest, LeavesOutAWildTimeThoughItLiesBetweenOthers) {
  std::vector<std::int64_t> times;
  for (int i = 0; i < 20; ++i) times.push_back(100 * i);
  times[12] = 350;
  times[15] = 1'000'000;
  const OrderedRows ordered = Ordered(&times);
  EXPECT_EQ(ordered.num_left_out, 2);
  EXPECT_EQ(ordered.num_moved, 0);
  EXPECT_EQ(times.size(), 18u);
}

TEST(OrderByTimeTest, SortsAListThatWasNeverInOrder) {
  std::vector<std::int64_t> times;
  for (int i = 0; i < 50; ++i) times.push_back(100 * (i * 37 % 50));
  times.push_back(100);  // which is there already
  const OrderedRows ordered = Ordered(&times);
  EXPECT_EQ(ordered.num_left_out, 1);
  ASSERT_EQ(times.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(times[static_cast<std::size_t>(i)], 100 * i);
}

}  // namespace
}  // namespace terrace
