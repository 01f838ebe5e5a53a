// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace terrace::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// Something that reads bytes which anyone may have written. It may refuse them as its header says; whatever
/// else happens is found by the sanitizers.
struct Target {
  const char* name;
  void (*read)(Bytes bytes);
};

/// Files: images, calibrations, sequences, logs, results.
std::vector<Target> FileTargets();
/// Configurations, scenes, saved maps, and the commands with their arguments.
std::vector<Target> SettingTargets();
/// Messages on the bus.
std::vector<Target> MessageTargets();

}  // namespace terrace::fuzz
