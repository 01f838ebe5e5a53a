// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace terrace {

/// How far rounding may take a figure from its true value.
constexpr double kExact = 1e-9;

}  // namespace terrace
