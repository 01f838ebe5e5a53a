// SPDX-License-Identifier: BSD-3-Clause
#include "client/map_from_log.h"

#include <lcm/lcm-cpp.hpp>

#include "client/terrain_follower.h"
#include "core/file_bytes.h"

namespace terrace {

TerrainMapPtr MapFromLog(const std::filesystem::path& log, Timestamp t, const ChannelConfig& channels) {
  lcm::LogFile file(log.string(), "r");
  if (!file.good()) throw FileError(log.string() + ": cannot be read");
  TerrainFollower follower;
  TerrainMapPtr map;
  while (const lcm::LogEvent* event = file.readNextEvent()) {
    if (event->channel != channels.terrain) continue;
    if (!follower.Receive(event->data, static_cast<std::size_t>(event->datalen))) continue;
    if (follower.map()->t_capture > t) break;
    map = follower.map();
  }
  if (!map) throw FileError(log.string() + ": holds no whole map of that time on " + channels.terrain);
  return map;
}

}  // namespace terrace
