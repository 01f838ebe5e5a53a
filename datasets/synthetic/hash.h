// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace terrace::synthetic {

/// Turns every bit of the input into half the bits of the output (constants of the "lowbias32" search, C.
/// Wellons).
constexpr std::uint32_t Hash(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  x ^= x >> 16;
  return x;
}

constexpr std::uint32_t Hash(std::uint32_t a, std::uint32_t b) {
  return Hash(Hash(a) + 0x9e3779b9U * (b + 1));
}
constexpr std::uint32_t Hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return Hash(Hash(a, b), c);
}

/// In [0, 1), of 24 bits.
constexpr double Unit(std::uint32_t hash) { return (hash >> 8) * (1.0 / 16777216.0); }

/// A stream of numbers that depends on nothing but its seed.
class Random {
 public:
  explicit Random(std::uint32_t seed) : seed_(seed) {}
  double Uniform() { return Unit(Hash(seed_, count_++)); }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Mean 0, standard deviation 1.
  double Gaussian() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform());
  }

 private:
  std::uint32_t seed_;
  std::uint32_t count_ = 0;
};

}  // namespace terrace::synthetic
