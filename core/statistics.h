// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace terrace {

/// Order statistics of a series, by nearest rank; zeros when it is empty.
struct Quantiles {
  double p50 = 0.0;
  double p90 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// Collects a series in bounded memory: count, sum and maximum of all values, quantiles of the newest
/// `capacity`.
class Series {
 public:
  explicit Series(std::size_t capacity = 65536);

  void Add(double value);

  std::int64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }
  Quantiles quantiles() const;
  /// The values that quantiles are made of, in no particular order.
  const std::vector<double>& newest() const { return newest_; }

 private:
  std::size_t capacity_;
  std::int64_t count_ = 0;
  double sum_ = 0.0;
  double max_ = 0.0;
  std::vector<double> newest_;  // a ring once it is full
};

/// The value below which the share `p` (0..1) of the values lies, by nearest rank; 0 when there are none.
double Quantile(std::vector<double> values, double p);

}  // namespace terrace
