// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

namespace terrace {

constexpr double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }
constexpr double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

}  // namespace terrace
