// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "core/time.h"

namespace terrace {

/// Leaves out as few rows as possible so that their times rise strictly; returns how many. One wild time
/// stamp costs one row, not all that follow it.
template <typename Row, typename TimeOf>
std::int64_t KeepRising(std::vector<Row>* rows, TimeOf time_of) {
  // Longest strictly rising subsequence by patience sorting: tails[k] is the row with the earliest time that
  // ends a rising chain of k + 1 rows.
  std::vector<std::size_t> tails;
  std::vector<std::size_t> before(rows->size());
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const Timestamp t = time_of((*rows)[i]);
    const auto place = std::lower_bound(tails.begin(), tails.end(), t, [&](std::size_t j, Timestamp time) {
      return time_of((*rows)[j]) < time;
    });
    before[i] = place == tails.begin() ? kNone : *(place - 1);
    if (place == tails.end()) {
      tails.push_back(i);
    } else {
      *place = i;
    }
  }
  const std::int64_t num_left_out = static_cast<std::int64_t>(rows->size() - tails.size());
  if (num_left_out == 0) return 0;
  std::vector<std::size_t> chain;
  for (std::size_t i = tails.back(); i != kNone; i = before[i]) chain.push_back(i);
  std::vector<Row> kept;
  kept.reserve(chain.size());
  for (auto i = chain.rbegin(); i != chain.rend(); ++i) kept.push_back(std::move((*rows)[*i]));
  *rows = std::move(kept);
  return num_left_out;
}

/// What became of rows that were not in the order of their times.
struct OrderedRows {
  std::int64_t num_moved = 0, num_left_out = 0;
};

/// Puts the rows of a list in the order of their times. A row that stands elsewhere belongs where its time
/// says if the others leave a gap there, or if the list was never in order; otherwise its time is wild, and
/// it is left out, as is one whose time another row has.
template <typename Row, typename TimeOf>
OrderedRows OrderByTime(std::vector<Row>* rows, TimeOf time_of) {
  std::vector<Timestamp> rising;
  rising.reserve(rows->size());
  for (const Row& row : *rows) rising.push_back(time_of(row));
  if (KeepRising(&rising, [](Timestamp t) { return t; }) == 0) return {};
  const std::size_t num_elsewhere = rows->size() - rising.size();
  constexpr std::size_t kFewest = 3, kNeverInOrder = 10;  // of so many rows one
  const bool never = num_elsewhere >= kFewest && num_elsewhere * kNeverInOrder > rows->size();

  std::stable_sort(rows->begin(), rows->end(),
                   [&](const Row& a, const Row& b) { return time_of(a) < time_of(b); });
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < rising.size(); ++i) steps.push_back(rising[i].ns - rising[i - 1].ns);
  std::sort(steps.begin(), steps.end());
  const std::int64_t gap_ns = steps.empty() ? 0 : steps[(steps.size() - 1) / 2] * 3 / 2;

  OrderedRows counts;
  std::vector<Row> kept;
  kept.reserve(rows->size());
  for (Row& row : *rows) {
    const Timestamp t = time_of(row);
    const bool again = !kept.empty() && time_of(kept.back()) == t;
    const auto next = std::lower_bound(rising.begin(), rising.end(), t);
    const bool stood_right = next != rising.end() && *next == t;
    const bool within = next != rising.begin() && next != rising.end();
    const bool in_gap = within ? next->ns - (next - 1)->ns > gap_ns
                               : std::abs(t.ns - (next == rising.end() ? rising.back() : *next).ns) <= gap_ns;
    if (again || !(stood_right || never || in_gap)) {
      ++counts.num_left_out;
      continue;
    }
    counts.num_moved += !stood_right;
    kept.push_back(std::move(row));
  }
  *rows = std::move(kept);
  return counts;
}

}  // namespace terrace
