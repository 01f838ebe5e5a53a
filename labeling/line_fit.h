// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

namespace terrace {

/// One value of a line.
struct LineValue {
  double x = 0.0;
  double y = 0.0;
  double sigma = 1.0;         ///< how well y is known beside the offset of its kind
  double share = 1.0;         ///< of the fragments of one thing, which count as one value together
  double offset_sigma = 0.0;  ///< values of its kind share an offset, 0 as well as this; 0: there is none
};

/// y = at_zero + slope x, as well as values say it together.
struct LineFit {
  double at_zero = 0.0;
  double slope = 0.0;
  double slope_sigma = 0.0;  ///< grows when the values scatter by more than they claim
  double rms = 0.0;          ///< of what the values leave, by their weights; of few as much as they claim
};

/// Least squares of a line whose values come in kinds: those with the same `offset_sigma` share one offset
/// from the line, which is found with it. None when the values do not tell the slope.
std::optional<LineFit> FitLine(const std::vector<LineValue>& values);

}  // namespace terrace
