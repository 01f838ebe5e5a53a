// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live_config.h"

namespace terrace {

std::vector<std::string> LiveConfig::Problems() const {
  if (url.find("://") == std::string::npos) return {"url = " + url + " must read provider://address, as LCM has it"};
  return {};
}

}  // namespace terrace
