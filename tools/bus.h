// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <lcm/lcm-cpp.hpp>

#include "daemon/config.h"

namespace CLI {
class App;
}

namespace terrace {

/// Where the daemon is: the file that it runs with names address and channels.
struct BusOptions {
  std::string config_file;
  std::vector<std::string> settings;
  std::string url;
};

/// --config and --set of a subcommand that reads logs, whose channels they name.
void AddChannelOptions(CLI::App* command, BusOptions* options);

/// --config, --set and --url of a subcommand that speaks with a daemon.
void AddBusOptions(CLI::App* command, BusOptions* options);

/// The daemon's configuration, with the address replaced where one is given. Throws UsageError with every
/// problem.
Config ConfigOf(const BusOptions& options);

/// Handles what arrives within `patience_ms`. Throws when LCM has failed; a signal is no failure.
void HandleFor(lcm::LCM* lcm, int patience_ms);

}  // namespace terrace
