// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <string>

namespace terrace {

/// Where messages come and go when nobody says where: what LCM_DEFAULT_URL names, as LCM's own programs have
/// it, else what is given.
inline std::string DefaultUrl(const std::string& otherwise) {
  const char* of_environment = std::getenv("LCM_DEFAULT_URL");
  return of_environment != nullptr && *of_environment != '\0' ? of_environment : otherwise;
}

/// On this computer only, with a receive buffer that keeps images whole.
inline std::string DefaultUrl() {
  return DefaultUrl("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
}

}  // namespace terrace
