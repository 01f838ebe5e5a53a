// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/finding.h"

namespace terrace {

/// What of a computer decides whether images reach the daemon and whether it keeps up.
struct HostFacts {
  std::int64_t rmem_max_bytes = 0;     ///< net.core.rmem_max
  std::int64_t recv_buffer_bytes = 0;  ///< that lcm.url asks for; 0: the kernel's default
  bool is_multicast = false;           ///< lcm.url begins with udpm://
  int ttl = 0;                         ///< of lcm.url: 0 stays on this computer
  bool has_route = false;              ///< packets to the group have somewhere to go
  std::int64_t available_memory_bytes = 0;
  int num_cores = 0;
  double load = 0.0;          ///< processes that want to run, over the last minute
  std::string governor;       ///< of the processor's frequency; empty: it has none
  bool clock_is_set = false;  ///< the kernel holds its clock for synchronised
};

/// Of this computer, for that LCM address.
HostFacts ReadHostFacts(const std::string& url);

/// One finding for each fact.
std::vector<Finding> JudgeHost(const HostFacts& facts);

}  // namespace terrace
