// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include <lcm/lcm-cpp.hpp>

namespace terrace {

/// Whether messages can come and go. LCM calls a connection good that has no socket, as tcpq:// without a
/// server, and ends the program when it is waited for.
inline bool IsOpen(lcm::LCM& lcm) { return lcm.good() && lcm.getFileno() >= 0; }

/// Throws std::runtime_error with a sentence when it is not open.
/// @param name  what its address is called where it was given
inline void RequireOpen(lcm::LCM& lcm, const std::string& name) {
  if (!IsOpen(lcm))
    throw std::runtime_error(name + ": cannot be opened; is there a network route, and for tcpq a server?");
}

}  // namespace terrace
