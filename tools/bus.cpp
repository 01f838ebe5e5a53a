// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bus.h"

#include <cerrno>
#include <csignal>
#include <optional>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "lcmtypes/open_bus.h"
#include "tools/commands.h"

namespace terrace {
namespace {

volatile std::sig_atomic_t tool_interrupted = 0;

}  // namespace

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

void CatchInterruptsOfTool() {
  struct sigaction action {};
  action.sa_handler = [](int) { tool_interrupted = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool ToolInterrupted() { return tool_interrupted != 0; }

void HandleFor(lcm::LCM* lcm, int patience_ms) {
  if (lcm->handleTimeout(patience_ms) < 0 && errno != EINTR) throw std::runtime_error("LCM has failed");
}

void RequireGood(lcm::LCM* lcm, const std::string& url) {
  if (!IsOpen(*lcm))
    throw std::runtime_error(url + ": cannot be opened; is there a network route, and for tcpq a server?");
}

}  // namespace terrace
