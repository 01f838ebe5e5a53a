// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/time.h"
#include "datasets/time_order.h"

namespace terrace {

/// The whole cell as a number; none when it is anything else, infinite or not a number.
std::optional<double> ParseDouble(std::string_view cell);
std::optional<std::int64_t> ParseInt64(std::string_view cell);
/// Nanoseconds since the epoch, not negative: differences of two such times cannot overflow.
std::optional<Timestamp> ParseNanoseconds(std::string_view cell);

/// "1 line", "2 lines".
std::string Counted(std::int64_t count, const std::string& noun);

/// The first `count` cells from `first` on as numbers; none when one is missing or not a number.
std::optional<std::vector<double>> ParseDoubles(std::span<const std::string_view> cells, std::size_t first,
                                                std::size_t count);

/// Reads a table of text line by line in bounded memory, whatever the file holds.
class TableReader {
 public:
  /// @param separator  ',' or ' ' (any run of blanks).
  TableReader(const std::filesystem::path& path, char separator);
  ~TableReader();
  TableReader(const TableReader&) = delete;
  TableReader& operator=(const TableReader&) = delete;

  /// Goes to the next line that is neither empty nor a comment (#); false at the end.
  bool Next();
  /// Trimmed cells of the line, at most 64; none for a line longer than any row of numbers.
  std::span<const std::string_view> cells() const { return cells_; }
  std::int64_t line_number() const { return line_number_; }
  /// Why the file could not be opened; empty: it could.
  const std::string& problem() const { return problem_; }

 private:
  struct Input;
  std::unique_ptr<Input> input_;
  char separator_;
  std::vector<std::string_view> cells_;
  std::int64_t line_number_ = 0;
  std::string problem_;
};

template <typename Row>
struct Table {
  std::vector<Row> rows;
  /// Why there are no rows: the file and the rule; empty when there are.
  std::string problem;
  /// What was left out, a sentence each that names the file, the rule and the first line.
  std::vector<std::string> warnings;
  /// Rows left out because their time did not rise.
  std::int64_t num_time_jumps = 0;
};

/// Reads all rows of a table. A first line that is no row is taken for a heading.
/// @param rule  what a row must be, for messages: "a time stamp [ns] and a file name".
/// @param parse  cells -> std::optional<Row>.
template <typename Row, typename Parse>
Table<Row> ReadTable(const std::filesystem::path& path, char separator, const std::string& rule,
                     Parse parse) {
  // Half a day of a 200 Hz sensor; more is not a recording but an attack on the memory.
  constexpr std::size_t kMaxRows = 10'000'000;
  Table<Row> table;
  TableReader reader(path, separator);
  if (!reader.problem().empty()) {
    table.problem = reader.problem();
    return table;
  }
  std::int64_t num_lines = 0;
  std::int64_t num_bad = 0;
  std::int64_t first_bad = 0;
  while (reader.Next()) {
    if (table.rows.size() == kMaxRows) {
      table.warnings.push_back(path.string() + ": only the first " + std::to_string(kMaxRows) +
                               " rows are used");
      break;
    }
    std::optional<Row> row = parse(reader.cells());
    if (row) {
      table.rows.push_back(std::move(*row));
    } else if (num_lines > 0 && num_bad++ == 0) {
      first_bad = reader.line_number();
    }
    ++num_lines;
  }
  if (table.rows.empty()) {
    table.problem = path.string() + ": no line holds " + rule;
  } else if (num_bad > 0) {
    table.warnings.push_back(path.string() + ": " + Counted(num_bad, "line") +
                             " left out, the first is line " + std::to_string(first_bad) +
                             ": a line must hold " + rule);
  }
  return table;
}

/// Leaves out of a table as few rows as possible so that their times rise, and says so: for rows whose order
/// is known otherwise. @param noun  what a row is: "image".
template <typename Row>
void LeaveOutTimeJumps(const std::filesystem::path& path, const std::string& noun, Table<Row>* table) {
  table->num_time_jumps += KeepRising(&table->rows, [](const Row& row) { return row.t; });
  if (table->num_time_jumps > 0) {
    table->warnings.push_back(path.string() + ": " + Counted(table->num_time_jumps, noun) +
                              " left out: time stamps must rise");
  }
}

/// Puts the rows of a table in the order of their times, leaves out what has no place there, and says so.
template <typename Row>
void SortByTime(const std::filesystem::path& path, const std::string& noun, Table<Row>* table) {
  const OrderedRows ordered = OrderByTime(&table->rows, [](const Row& row) { return row.t; });
  table->num_time_jumps = ordered.num_left_out;
  if (ordered.num_moved > 0) {
    table->warnings.push_back(path.string() + ": " + Counted(ordered.num_moved, noun) +
                              " not in the order of their times: sorted");
  }
  LeaveOutTimeJumps(path, noun, table);
}

}  // namespace terrace
