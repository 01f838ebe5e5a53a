// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace terrace {

/// The greatest integer that is not above x; |x| below 2^31. std::floor is a call into the C library where
/// the processor's own rounding may not be taken for granted.
template <typename Real>
inline int FloorToInt(Real x) {
  const int towards_zero = static_cast<int>(x);
  return towards_zero - static_cast<int>(static_cast<Real>(towards_zero) > x);
}

}  // namespace terrace
