// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace terrace {

/// A smooth, never repeating grey texture, defined everywhere: sums of waves of many lengths and directions.
inline double Texture(double x, double y) {
  double sum = 0.0;
  for (int k = 1; k <= 12; ++k) {
    const double angle = 2.4 * k;
    const double wave = 0.12 + 0.045 * k;
    sum += std::sin(wave * (std::cos(angle) * x + std::sin(angle) * y) + 1.7 * k * k);
  }
  return 128.0 + 18.0 * sum;
}

}  // namespace terrace
