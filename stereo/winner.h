// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace terrace {

/// How sure the best sum of a pixel must be.
struct WinnerRules {
  /// No disparity further than one from the best may have a sum below best * (1 + this / 100).
  int uniqueness_percent = 5;
  /// Greatest difference between the disparities of the two views; negative: not checked.
  int max_left_right_error = 1;
};

/// What to choose from: the summed costs of one row as PathAggregator gives them.
struct SumsRow {
  const std::uint8_t* sums = nullptr;
  int width = 0;
  int num_disparities = 0;
  const std::int16_t* first = nullptr;  ///< disparity of each pixel's range
};

/// The best sums of the pixels of a row, where they stand, and those beside them.
struct WinnersRow {
  std::uint8_t* index;
  std::uint8_t* sum;
  std::uint8_t* unique;           ///< 0: no
  std::uint8_t *before, *behind;  ///< sums at index - 1 and + 1; both `sum` where there is only one of them
};

/// Chooses the disparities of both views.
class WinnerChooser {
 public:
  explicit WinnerChooser(const WinnerRules& rules);

  /// The disparity of every pixel of a row, between the whole numbers by a parabola through the best sum and
  /// its neighbours; NaN where it is not unique, where the two views disagree, or where it leads out of the
  /// right image.
  void Choose(const SumsRow& row, float* disparity);

  /// The best sum of each pixel of the row before, whether or not it was then kept.
  const std::uint8_t* best_sums() const { return bytes_.data() + bytes_.size() / kNumBytes; }

 private:
  static constexpr std::size_t kNumBytes = 5;  // of a winner

  WinnerRules rules_;
  std::array<std::uint8_t, 256> limit_of_sum_;  ///< that a rival must exceed
  std::vector<std::uint8_t> bytes_;             ///< of the winners
  std::vector<std::int32_t> right_claims_;
  std::vector<float> disparity_;
};

}  // namespace terrace
