// SPDX-License-Identifier: BSD-3-Clause
#include "core/parallel_for.h"

#include <numeric>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(ParallelForTest, VisitsEveryIndexOnceAndSeesWhatWasWrittenBefore) {
  std::vector<int> input(10000);
  std::iota(input.begin(), input.end(), 0);
  std::vector<int> output(input.size(), 0);
  ParallelFor(static_cast<int>(input.size()), [&](int i) { output[i] += 2 * input[i]; });
  for (int i = 0; i < static_cast<int>(output.size()); ++i) ASSERT_EQ(output[i], 2 * i);
}

TEST(ParallelForTest, PiecesCoverTheWholeAndNothingElse) {
  std::vector<int> visits(777, 0);
  ParallelForPieces(visits.size(), [&](std::size_t begin, std::size_t end) {
    ASSERT_LT(begin, end);
    for (std::size_t i = begin; i < end; ++i) ++visits[i];
  });
  EXPECT_EQ(visits, std::vector<int>(777, 1));
  ParallelForPieces(0, [](std::size_t, std::size_t) { FAIL() << "there is nothing to do"; });
}

TEST(ParallelForTest, WhatABodyThrowsReachesTheCaller) {
  EXPECT_THROW(ParallelFor(100,
                           [](int i) {
                             if (i == 42) throw std::runtime_error("no");
                           }),
               std::runtime_error);
}

}  // namespace
}  // namespace terrace
