// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bus.h"

#include <cerrno>
#include <optional>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "tools/commands.h"

namespace terrace {

void AddChannelOptions(CLI::App* command, BusOptions* options) {
  command->add_option("--config", options->config_file, "the daemon's configuration: the channels of a log");
  command->add_option("--set", options->settings, "overrides one key of it: channels.images=NAME")
      ->allow_extra_args(false);
}

void AddBusOptions(CLI::App* command, BusOptions* options) {
  command->add_option("--config", options->config_file,
                      "the daemon's configuration: its address and channels");
  command->add_option("--set", options->settings, "overrides one key of it: section.key=value")
      ->allow_extra_args(false);
  command->add_option("--url", options->url, "LCM provider, instead of lcm.url");
}

Config ConfigOf(const BusOptions& options) {
  std::optional<std::filesystem::path> file;
  if (!options.config_file.empty()) file = options.config_file;
  std::vector<std::string> settings = options.settings;
  if (!options.url.empty()) settings.push_back("lcm.url=" + options.url);
  try {
    return LoadConfig(file, settings);
  } catch (const ConfigError& error) {
    throw UsageError(error.what());
  }
}

void HandleFor(lcm::LCM* lcm, int patience_ms) {
  if (lcm->handleTimeout(patience_ms) < 0 && errno != EINTR) throw std::runtime_error("LCM has failed");
}

}  // namespace terrace
