// SPDX-License-Identifier: BSD-3-Clause
#include "client/map_from_log.h"

#include <cstdint>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "client/terrain_client.h"
#include "core/file_bytes.h"
#include "core/map_difference.h"
#include "lcmtypes/terrain_codec.h"
#include "test/datasets/temporary_folder.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

TEST(MapFromLogTest, IsTheMapAsItWasAtEachMoment) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "bus.lcmlog").string();
  ExampleMaps example(7);
  std::vector<TerrainMap> states{example.First(12)};
  {
    lcm::LogFile log(path, "w");
    std::int64_t number = 0;
    const auto write = [&](const std::vector<terrain_v1_t>& messages) {
      for (const terrain_v1_t& message : messages) {
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
        message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
        lcm::LogEvent event{};
        event.eventnum = number++;
        event.timestamp = message.utime;
        event.channel = "TERRACE_TERRAIN";
        event.data = bytes.data();
        event.datalen = static_cast<std::int32_t>(bytes.size());
        log.writeEvent(&event);
      }
    };
    write(SnapshotMessages(states.back()));
    for (int i = 0; i < 6; ++i) {
      states.push_back(example.Next(states.back()));
      write(DeltaMessages(states[states.size() - 2], states.back()));
    }
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    const TerrainMapPtr map = TerrainClient::FromLog(path, states[i].t_capture);
    EXPECT_EQ(map->seq, states[i].seq);
    EXPECT_EQ(map->regions.size(), states[i].regions.size());
  }
  try {
    MapFromLog(path, {states.front().t_capture.ns - 1});
    FAIL() << "there was no map yet";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no whole map"));
  }
  EXPECT_THROW(MapFromLog(folder.path() / "other.lcmlog", {0}), FileError);
}

}  // namespace
}  // namespace terrace
