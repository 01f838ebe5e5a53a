// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "core/terrain_map.h"
#include "core/time.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// The newest state of the map, out of an LCM log of the bus, of which no image is newer than `t`. A log that
/// begins within a run has its first map with the first snapshot in it (`lcm.snapshot_period_s`). Throws
/// FileError when it cannot be read or holds no such state.
TerrainMapPtr MapFromLog(const std::filesystem::path& log, Timestamp t, const ChannelConfig& channels = {});

}  // namespace terrace
