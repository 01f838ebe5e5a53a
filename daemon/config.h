// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/live_config.h"
#include "daemon/pipeline_config.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// Everything that can be set about the daemon: the YAML file, section by section.
struct Config {
  PipelineConfig pipeline;
  LiveConfig live;
  ChannelConfig channels;
};

/// The configuration cannot be used; what() lists every problem, a line each, with file, key, value and rule.
class ConfigError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Defaults, overridden by the file, overridden by the settings `section.key=value`. Throws ConfigError.
Config LoadConfig(const std::optional<std::filesystem::path>& file, const std::vector<std::string>& settings);

/// The complete YAML file of a configuration, with a comment above every key.
std::string PrintConfig(const Config& config);

/// A short fingerprint of every value, for the status message.
std::string ConfigHash(const Config& config);

}  // namespace terrace
