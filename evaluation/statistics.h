// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace terrace {

// Of plain samples; 0 of none, so that callers report the count beside it.

inline double MeanOf(const std::vector<double>& samples) {
  double sum = 0.0;
  for (double x : samples) sum += x;
  return samples.empty() ? 0.0 : sum / static_cast<double>(samples.size());
}

inline double RmsOf(const std::vector<double>& samples) {
  double sum = 0.0;
  for (double x : samples) sum += x * x;
  return samples.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(samples.size()));
}

/// The smallest sample that at least `share` (0..1) of them do not exceed; for 0.5 the lower median.
inline double QuantileOf(std::vector<double> samples, double share) {
  if (samples.empty()) return 0.0;
  const double rank = std::ceil(share * static_cast<double>(samples.size())) - 1.0;
  const auto index = static_cast<std::ptrdiff_t>(std::max(rank, 0.0));
  std::nth_element(samples.begin(), samples.begin() + index, samples.end());
  return samples[static_cast<std::size_t>(index)];
}

}  // namespace terrace
