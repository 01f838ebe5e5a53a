// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

/// How the live daemon listens and speaks. YAML section: `lcm`.
struct LiveConfig {
  /// LCM provider. A receive buffer of 2 MB keeps images whole; net.core.rmem_max must allow it.
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
