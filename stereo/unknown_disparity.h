// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

namespace terrace {

/// The disparity, and the sigma, of a pixel without one.
constexpr float kUnknownDisparity = std::numeric_limits<float>::quiet_NaN();

}  // namespace terrace
