// SPDX-License-Identifier: BSD-3-Clause
#include "core/statistics.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace terrace {

Series::Series(std::size_t capacity) : capacity_(capacity) { TERRACE_CHECK(capacity > 0); }

void Series::Add(double value) {
  max_ = count_ == 0 ? value : std::max(max_, value);
  if (newest_.size() < capacity_) {
    newest_.push_back(value);
  } else {
    newest_[static_cast<std::size_t>(count_) % capacity_] = value;
  }
  ++count_;
  sum_ += value;
}

Quantiles Series::quantiles() const {
  return {Quantile(newest_, 0.5), Quantile(newest_, 0.9), Quantile(newest_, 0.99), max_};
}

double Quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  const auto n = static_cast<double>(values.size());
  const auto rank = static_cast<std::ptrdiff_t>(std::clamp(std::ceil(p * n) - 1.0, 0.0, n - 1.0));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

}  // namespace terrace
