// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>

#include "client/terrace_file.h"
#include "core/explanation.h"
#include "daemon/map_placing.h"

namespace terrace {

/// What a daemon can be told to do, by whoever knows how.
struct CommandActions {
  std::function<void()> reset_map;
  std::function<void(bool paused)> pause_map;
  std::function<bool()> send_snapshot;                   ///< false: there is no map yet
  std::function<SavedMap()> map;                         ///< without a map: there is none yet
  std::function<Explanations(std::int64_t id)> explain;  ///< of region and staircase with this id
  /// A map from a file, and where the body is in it; false: no camera is known yet.
  std::function<bool(SavedMap map, const std::string& file, const std::optional<BodyInMap>& body)> load_map;
};

/// Obeys the commands that arrive on the bus, where anyone can send anything.
class CommandObeyer {
 public:
  /// @param save_folder  into which SAVE_MAP writes and from which LOAD_MAP reads; empty: neither
  CommandObeyer(std::filesystem::path save_folder, CommandActions actions)
      : save_folder_(std::move(save_folder)), actions_(std::move(actions)) {}

  /// Never throws.
  command_reply_v1_t Obey(const command_v1_t& command);

 private:
  command_reply_v1_t SaveMap(const std::string& name) const;
  command_reply_v1_t LoadMap(const std::string& argument) const;
  command_reply_v1_t Explain(const std::string& argument) const;

  const std::filesystem::path save_folder_;
  const CommandActions actions_;
};

}  // namespace terrace
