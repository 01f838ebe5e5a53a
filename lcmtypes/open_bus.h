// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <lcm/lcm-cpp.hpp>

namespace terrace {

/// Whether messages can come and go. LCM calls a connection good that has no socket, as tcpq:// without a server, and
/// ends the program when it is waited for.
inline bool IsOpen(lcm::LCM& lcm) { return lcm.good() && lcm.getFileno() >= 0; }

}  // namespace terrace
